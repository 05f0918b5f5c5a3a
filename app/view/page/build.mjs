// Bundles the page: node build.mjs OUT_DIR LICENCES writes index.html, view.js, socket.js, view.css, saved.html and
// licences.txt, each compressed, with .gz behind its name. LICENCES is licences.txt as it is, for installations.
import { build } from 'esbuild';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

if (process.argv.length !== 4) {
  console.error('usage: node build.mjs OUT_DIR LICENCES');
  process.exit(2);
}
const here = dirname(fileURLToPath(import.meta.url));
const out = resolve(process.argv[2]);
mkdirSync(out, { recursive: true });

const result = await build({
  absWorkingDir: here,
  entryPoints: { view: 'src/main.js', socket: 'src/socket.js' },
  outdir: out,
  bundle: true,
  format: 'iife',
  minify: true,
  target: ['es2021'],
  charset: 'utf8',
  legalComments: 'inline',
  write: false,
  metafile: true,
  logLevel: 'warning',
});
const text_of = (name) => {
  const file = result.outputFiles.find((one) => one.path.endsWith(name));
  if (!file) throw new Error(`esbuild wrote no ${name}`);
  return file.text;
};
const program = text_of('view.js');
const style = text_of('view.css');
const frame = readFileSync(join(here, 'src/index.html'), 'utf8');

/** Puts text in the place of a mark that must be there once; a function, so that no $ is special. */
const put = (page, mark, text) => {
  if (page.split(mark).length !== 2) throw new Error(`${mark} is not there once`);
  return page.replace(mark, () => text);
};
const served = put(put(put(frame, '<!--STYLE-->', '<link rel="stylesheet" href="view.css">'), '<!--RECORDING_PLACE-->\n', ''),
  '<!--PROGRAM-->', '<script defer src="view.js"></script>');
// Inside of a script element, these begin or end something else.
const inlined = program.replace(/<\/(script)/gi, '<\\/$1').replace(/<!--/g, '<\\!--');
const policy = `<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">`;
const saved = put(put(put(frame, '<!--STYLE-->', `${policy}\n<style>\n${style.replace(/<\/(style)/gi, '<\\/$1')}</style>`),
  '<!--RECORDING_PLACE-->', '<!--TACTOR_RECORDING-->'), '<!--PROGRAM-->', `<script>\n${inlined}</script>`);
if (saved.split('<!--TACTOR_RECORDING-->').length !== 2) throw new Error('saved.html must name the place of the recording once');

// Every package of which a source is in the bundle.
const bundled = new Set(Object.keys(result.metafile.inputs).map((path) => path.match(/^node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1]));
bundled.delete(undefined);
const licences = [...bundled].sort().map((name) => {
  const about = JSON.parse(readFileSync(join(here, 'node_modules', name, 'package.json'), 'utf8'));
  return `${about.name} ${about.version} (${about.license})\n\n${readFileSync(join(here, 'node_modules', name, 'LICENSE'), 'utf8').trim()}\n`;
});

const files = { 'index.html': served, 'view.js': program, 'socket.js': text_of('socket.js'), 'view.css': style, 'saved.html': saved,
  'licences.txt': `The page holds these works of others.\n\n${licences.join(`\n${'-'.repeat(78)}\n\n`)}` };
for (const [name, text] of Object.entries(files)) writeFileSync(join(out, `${name}.gz`), gzipSync(text, { level: 9 }));
writeFileSync(process.argv[3], files['licences.txt']);
