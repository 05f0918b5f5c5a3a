// What the page says released the force: by enumerations, whatever comes together.
import assert from 'node:assert/strict';
import test from 'node:test';
import { release_of, without_words } from '../src/release.js';

const HELD = { engagement: 'engaged', cause: 'none', hold: 'held', phase: 'running', control: 'me', connected: true };
const released = (more) => release_of({ ...HELD, engagement: 'disengaged', ...more });

test('nothing is said while the force is in, or comes in', () => {
  assert.equal(release_of(HELD), null);
  assert.equal(release_of({ ...HELD, engagement: 'ramping' }), null);
});

test('a button that was let go is told from a page that was silent or closed', () => {
  assert.match(released({ cause: 'dead_man', hold: 'let_go' }).what, /^You let go/);
  assert.match(released({ cause: 'dead_man', hold: 'silent' }).again, /^Let go, then press/);
  assert.match(released({ cause: 'dead_man', hold: 'page_gone', control: 'nobody' }).what, /was closed/);
  assert.match(released({ cause: 'dead_man', hold: 'let_go', control: 'other' }).what, /^Another page is in control/);
});

test('a device of the graph has a button of its own', () => {
  assert.match(released({ cause: 'dead_man', hold: undefined }).what, /^Nobody holds the device/);
});

test('a force that is too late names the nodes that do not answer', () => {
  assert.match(released({ cause: 'stale' }).what, /too late/);
  assert.match(released({ cause: 'stale', stalled: ['dynamics'] }).what, /dynamics does not answer/);
});

test('an end and a lost connection come before all else', () => {
  assert.match(released({ cause: 'dead_man', end: 'stalled', connected: false }).what, /watchdog/);
  assert.match(released({ cause: 'dead_man', connected: false }).what, /connection is lost/);
});

test('a word of a newer server is not left out', () => {
  assert.match(released({ cause: 'something_new' }).what, /something_new/);
  assert.deepEqual(without_words({ causes: ['none', 'stale', 'new'], holds: ['held'], ends: ['over', 'other'] }), ['new', 'other']);
});
