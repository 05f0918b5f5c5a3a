// Builds the page: node build.mjs OUT. Needs what `npm ci` installs, and no network.
import {mkdir, readFile, writeFile} from 'node:fs/promises';
import {join} from 'node:path';
import {gzipSync} from 'node:zlib';
import {build} from 'esbuild';

const out = process.argv[2];
if (!out) throw new Error('expected the folder to build into: node build.mjs OUT');

async function bundle(entry, options = {}) {
  const result = await build({
    entryPoints: [entry], bundle: true, minify: true, write: false, legalComments: 'none', logLevel: 'warning',
    target: ['chrome100', 'firefox100', 'safari15.4'], ...options,
  });
  return result.outputFiles[0].text;
}

// A script element ends at the first </script, also inside of a text of the program.
const script = (await bundle('src/main.js', {format: 'iife'})).replaceAll('</script', '<\\/script');
const style = await bundle('src/style.css');
const body = await readFile('src/body.html', 'utf8');
const head = `<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark"><title>tactor</title>`;
const licences = await Promise.all(
    [['three', 'LICENSE'], ['uplot', 'LICENSE']].map(async ([name, file]) =>
      `${name}\n\n${await readFile(join('node_modules', name, file), 'utf8')}`));

const files = {
  'index.html': `<!doctype html>
<html lang="en"><head>${head}<link rel="icon" href="data:,"><link rel="stylesheet" href="/view.css"></head>
<body>${body}<script src="/view.js"></script></body></html>
`,
  'view.js': script,
  'view.css': style,
  // A function, because $& and the like mean something in a text.
  'saved.html': `<!doctype html>
<!-- With three and uPlot, whose licences are:

${licences.join('\n\n').replaceAll('--', '- -')}
-->
<html lang="en"><head>${head}<style>${style}</style></head>
<body>${body}<!--TACTOR_RECORDING--><script>${script}</script></body></html>
`,
  'licences.txt': `The page of tactor's view holds these programs.\n\n${licences.join('\n\n')}`,
};
await mkdir(out, {recursive: true});
for (const [name, text] of Object.entries(files)) await writeFile(join(out, `${name}.gz`), gzipSync(text, {level: 9}));
