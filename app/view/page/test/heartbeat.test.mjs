// When the worker of the page sends the newest input again.
import assert from 'node:assert/strict';
import test from 'node:test';
import { HANGS_AFTER, Heartbeat } from '../src/heartbeat.js';

/** The times in ms at which an input is sent again, looked at each 20 ms. */
function beats(heartbeat, from, to) {
  const times = [];
  for (let now = from; now <= to; now += 20) if (heartbeat.due(now) !== null) times.push(now);
  return times;
}

test('without an input there is no heartbeat', () => {
  assert.deepEqual(beats(new Heartbeat(), 0, 5000), []);
});

test('a page that draws for half a second is spoken for', () => {
  const heartbeat = new Heartbeat();
  for (let frame = 0; frame < 5; ++frame) {
    heartbeat.take(`input ${frame}`, 500 * frame);
    const times = beats(heartbeat, 500 * frame, 500 * frame + 499);
    const gaps = [500 * frame, ...times, 500 * frame + 500].map((t, i, all) => (i ? t - all[i - 1] : 0));
    assert.ok(Math.max(...gaps) <= 60, `${gaps}`);
  }
  assert.equal(heartbeat.due(2540), 'input 4');
});

test('a page that asks for silence is not spoken for until its next input', () => {
  const heartbeat = new Heartbeat();
  heartbeat.take('held', 0);
  heartbeat.fall_silent();
  assert.deepEqual(beats(heartbeat, 0, 5000), []);
  heartbeat.take('held', 6000);
  assert.equal(heartbeat.due(6040), 'held');
});

test('a page that hangs is spoken for no longer than stated', () => {
  const heartbeat = new Heartbeat();
  heartbeat.take('held', 0);
  assert.equal(beats(heartbeat, 0, 60000).at(-1), HANGS_AFTER);
  heartbeat.take('let go', 70000);
  assert.deepEqual(beats(heartbeat, 70000, 70050), [70040]);
});
