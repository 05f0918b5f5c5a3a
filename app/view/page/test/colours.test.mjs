// Force and tool are told apart, and the force from every method of a report.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import { COLOURS, colour_of } from '../src/colours.js';

const SOURCES = process.env.TACTOR_SOURCES ?? '../../..';
const METHODS = readFileSync(`${SOURCES}/app/report/chart.cpp`, 'utf8').match(/series_colors> colors\{([^}]*)\}/)[1].match(/#[0-9A-Fa-f]{6}/g);

const linear = (colour) => [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));

/** CIELAB of linear sRGB, D65. */
function lab([r, g, b]) {
  const f = (t) => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
  const [x, y, z] = [(0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047, 0.2126 * r + 0.7152 * g + 0.0722 * b, (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883].map(f);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

/** What a person without green cones sees (Machado, Oliveira and Fernandes 2009). */
const deuteranope = ([r, g, b]) => [0.367322 * r + 0.860646 * g - 0.227968 * b, 0.280085 * r + 0.672501 * g + 0.047413 * b, -0.01182 * r + 0.04294 * g + 0.968881 * b]
  .map((c) => Math.min(1, Math.max(0, c)));

/** The distance in CIELAB, 1976; about 2 can just be seen. */
const distance = (a, b, seen = (c) => c) => Math.hypot(...lab(seen(linear(a))).map((c, i) => c - lab(seen(linear(b)))[i]));

for (const theme of ['light', 'dark']) {
  const { force, tool, hand } = COLOURS[theme];
  test(`force and tool are far apart, also for colour-blind people: ${theme}`, () => {
    assert.ok(distance(force, tool) > 100);
    assert.ok(distance(force, tool, deuteranope) > 100);
    assert.ok(distance(force, hand) > 80);
  });

  test(`the force has no colour of a method: ${theme}`, () => {
    assert.equal(METHODS.length, 7);
    for (const method of METHODS) assert.ok(distance(force, method) > 35, method);
  });

  test(`no other curve looks like the force: ${theme}`, () => {
    for (const role of ['physics', 'predicted', 'interpolated', 'reference']) assert.ok(distance(colour_of(role, theme === 'dark'), colour_of('commanded', theme === 'dark')) > 35, role);
  });
}
