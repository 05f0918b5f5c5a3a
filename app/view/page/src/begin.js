// Makes the parts of the page by what the first message names.
import { app, dark_query, force_max, have_meshes, in_control, recording, set_parameter } from './app.js';
import { Cursor } from './cursor.js';
import { Diagram } from './diagram.js';
import { by_id, make, set_text, show } from './dom.js';
import { Experiment } from './experiment.js';
import { Guide } from './guide.js';
import { Knobs } from './knobs.js';
import { Methods } from './methods.js';
import { make_charts, moved } from './page_charts.js';
import { Replay } from './replay.js';
import { fetch_page } from './saving.js';
import { SceneView } from './scene.js';
import { Store } from './store.js';

export function begin() {
  const { hello } = app;
  if (!Array.isArray(hello.streams) || !hello.scene || !Array.isArray(hello.scene.bodies)) throw new Error('hello names no streams or no scene');
  hello.parameters ??= [];
  app.store = new Store(hello);
  app.counters.samples_taken = app.store.taken;
  for (const parameter of hello.parameters) app.values[parameter.name] = parameter.value;
  app.base_values = { ...app.values };
  document.body.classList.remove('waiting');
  document.body.classList.add(hello.mode);
  if (recording) document.body.classList.add('saved');
  document.title = `${hello.graph} – Tactor`;
  set_text(by_id('title'), [hello.graph, hello.title].filter(Boolean).join(': '));
  by_id('title').title = `${hello.title ?? ''}\nTactor ${hello.version ?? ''}`;
  const live = hello.mode === 'live';
  show(by_id('stop'), live);
  by_id('force-bar').setAttribute('aria-valuemax', force_max());
  if (hello.experiment && live) {
    // Blind: neither curves nor knobs, which would tell what is felt.
    document.body.classList.add('experiment');
    show(by_id('experiment'), true);
    app.experiment = new Experiment(by_id('experiment'), hello, set_parameter);
  }
  if (hello.methods) {
    show(by_id('methods'), live); // a replay shows them as soon as it knows of figures
    app.methods = new Methods(by_id('methods'), hello, set_parameter);
  }
  if (hello.parameters.length && !app.experiment) {
    show(by_id('knobs'), true);
    app.knobs = new Knobs(by_id('knobs'), hello.parameters, set_parameter, hello.methods?.parameter);
  }
  if (hello.nodes?.length) {
    show(by_id('graph'), true);
    app.diagram = new Diagram(by_id('diagram'), hello);
  }
  if (!live) {
    app.replay = new Replay(() => [app.store.begin ?? 0, Math.max(app.store.now ?? 0, app.store.begin ?? 0)], () => moved());
    app.replay.complete = app.complete;
    app.timeline.ahead = 0.25;
    if (hello.duration > 0) app.timeline.whole = hello.duration;
    app.knobs?.enable(false);
    app.methods?.enable(false);
  }
  make_charts();
  app.guide = new Guide(hello);
  if (app.experiment) show(by_id('guide'), false);
  if (!recording) setTimeout(() => fetch_page().catch(() => {}), 3000);
  if (have_meshes()) make_scene();
}

export function make_scene() {
  // A recorded force alone has nothing that could be drawn.
  if (!app.hello.scene.bodies.length && !app.hello.device?.mouse) {
    show(by_id('scene'), false);
    show(by_id('scene-bar'), false);
    app.scene_failed = true;
    return;
  }
  try {
    app.scene = new SceneView(by_id('scene'), app.hello, app.meshes);
  } catch (error) {
    by_id('scene').append(make('p', { class: 'absent', text: `No picture of the scene: ${error.message}. The charts work without it.` }));
    app.scene_failed = true;
    console.error(error);
    return;
  }
  app.scene.set_dark(dark_query.matches);
  const handle = app.store.role('handle');
  app.cursor = new Cursor({ scene: app.scene, hello: app.hello, send: (message) => app.connection?.send(message), fall_silent: () => app.connection?.fall_silent(),
    handle: () => (handle?.size ? handle.row(handle.end - 1) : null), allowed: () => Boolean(in_control()) });
  const layers = [['bodies', 'bodies', true], ['ground', 'grid', true]];
  if (handle) layers.push(['handle', 'handle', true]);
  if (app.store.role('contacts')) layers.push(['contacts', 'contacts', true]);
  if (app.store.role('patch')) layers.push(['patch', 'local model', true]);
  if (app.store.role('commanded')) layers.push(['commanded', 'force', true]);
  if (app.store.role('physics')) layers.push(['physics', 'physics force', false]);
  for (const [name, label, shown] of layers) {
    const box = make('input', { type: 'checkbox', id: `show-${name}`, checked: shown, on: { change: () => app.scene.show(name, box.checked) } });
    by_id('layers').append(make('label', { class: 'inline' }, [box, ...(/handle|commanded|contacts|physics|patch/.test(name) ? [make('span', { class: `swatch ${name}` })] : []), label]));
    app.scene.show(name, shown);
  }
  const base = app.scene.force_scale;
  by_id('arrow-scale').addEventListener('input', (event) => {
    app.scene.force_scale = base * 10 ** (event.target.value / 100);
    moved();
  });
  by_id('fit').addEventListener('click', () => app.scene.look());
  set_text(by_id('scene-hint'), app.hello.mode === 'live' && app.hello.device?.mouse
    ? `drag the tool${app.hello.rotates ? ', with R to turn' : ''}; keys: space and arrows` : 'drag to look around');
}
