// The colours of the page, each named once for scene, curves, bar and legend.

/**
 * `force`: what the device is given, in no colour of a method of reports; `tool`: what the hand holds, orange as in all pictures of
 * scenes, with `hand` for its lines. The others are of Okabe and Ito, which colour-blind readers can tell apart.
 */
export const COLOURS = {
  light: { force: '#6a1fb0', tool: '#e0a030', hand: '#6b4a00', physics: '#0072b2', predicted: '#cc79a7', interpolated: '#009e73',
    reference: '#9aa3ac', contacts: '#30363d', patch: '#cc79a7', p50: '#009e73', p99: '#e69f00', max: '#d55e00' },
  dark: { force: '#b07cff', tool: '#e6b050', hand: '#f2d59a', physics: '#56b4e9', predicted: '#cc79a7', interpolated: '#009e73',
    reference: '#7d8791', contacts: '#c9d1d9', patch: '#cc79a7', p50: '#009e73', p99: '#e69f00', max: '#d55e00' },
};
const SAME = { commanded: 'force', handle: 'tool', delay: 'physics', rate: 'physics' };

/** The colour of a role of a stream, or of one of the names above. @param {string} name @param {boolean} dark */
export const colour_of = (name, dark) => COLOURS[dark ? 'dark' : 'light'][SAME[name] ?? name] ?? '#777777';

/** Gives the colours to the style of the page, as --force, --tool and so on. @param {boolean} dark */
export function dress_page(dark) {
  for (const [name, colour] of Object.entries(COLOURS[dark ? 'dark' : 'light'])) document.documentElement.style.setProperty(`--${name}`, colour);
}
