// Saves what is shown as a page of its own.
import { app, have_meshes, tell } from './app.js';
import { by_id, set_text } from './dom.js';
import { download, saved_frame, saved_page } from './save.js';
import { LIVE_HISTORY } from './store.js';

let page_text = null;
/** The page to save into; fetched early, for a server whose run has ended is soon gone. */
export const fetch_page = () => (page_text ??= saved_frame().catch((error) => {
  page_text = null;
  throw error;
}));

by_id('save').addEventListener('click', async () => {
  if (!app.store || app.store.now === undefined || !have_meshes()) return;
  const button = by_id('save');
  button.disabled = true;
  set_text(button, 'Saving …');
  try {
    const { hello, meshes, store, told } = app;
    const from = hello.mode === 'replay' ? store.oldest : Math.max(store.oldest, store.now - LIVE_HISTORY);
    const parameters = hello.parameters.map((one) => ({ ...one, value: app.base_values[one.name] }));
    const blob = await saved_page(await fetch_page(), { hello: { ...hello, parameters, duration: store.now - from }, meshes, store, told }, { from, to: store.now });
    download(blob, `${hello.graph}.html`.replaceAll(/[^\w.-]/g, '_'));
    app.saved_bytes = blob.size;
  } catch (error) {
    tell(`Not saved: ${error.message}`);
  }
  button.disabled = false;
  set_text(button, 'Save as HTML');
});
