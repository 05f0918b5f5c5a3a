// What a participant is told in each phase, from a row of the stream.
import assert from 'node:assert/strict';
import test from 'node:test';
import { shown_of } from '../src/experiment.js';

const column = { phase: 0, trial: 1, block: 2, blocks: 3, progress: 4 };

test('a question is asked after the second interval', () => {
  const shown = shown_of([5, 7, 1, 2, 0.25], column);
  assert.equal(shown.phase, 'answering');
  assert.match(shown.text, /1 for the first, 2 for the second/);
  assert.equal(shown.count, 'part 1 of 2, trial 7');
  assert.equal(shown.progress, 0.25);
});

test('before the first trial nothing is counted, and one part needs no number', () => {
  const shown = shown_of([0, 0, 1, 1, 0], column);
  assert.equal(shown.phase, 'waiting');
  assert.equal(shown.count, '');
});
