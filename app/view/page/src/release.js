// Says in words what released the force, and how to engage it again, by the words of enumerations that the server sends.

/** @typedef {{what: string, again: string}} Release */

const ITSELF = 'The force comes back by itself.';
const HOLD = 'Press on the tool and hold it.';

/** Causes of the safety gate, but those that say more with what else is known. */
const CAUSES = {
  not_finite: { what: 'The computed force was not a number.', again: ITSELF },
  overspeed: { what: 'The device moved faster than its limit.', again: `Move slower. ${ITSELF}` },
  read_failed: { what: 'The device could not be read.', again: `Check its cable and its power. ${ITSELF}` },
  write_failed: { what: 'The device did not take the force.', again: `Check its cable and its power. ${ITSELF}` },
  time_reversed: { what: 'The clock went back.', again: ITSELF },
  time_gap: { what: 'The device loop was late.', again: ITSELF },
  outside_workspace: { what: 'The handle is outside the workspace of the device.', again: 'Bring it back.' },
  expired: { what: 'The device loop was late.', again: ITSELF },
  no_segment: { what: 'Physics has not given a force yet.', again: `Wait. ${ITSELF}` },
  device_not_ready: { what: 'The device is not ready.', again: `Switch it on, or calibrate it. ${ITSELF}` },
  dead_man: { what: 'Nobody holds the device.', again: 'Hold its dead-man button, or the tool.' },
  stale: { what: 'Physics is too late: no new force has come in time.', again: ITSELF },
  not_permitted: { what: 'The run starts or stops.', again: `Wait. ${ITSELF}` },
};

/** The dead-man button of the mouse. */
const HOLDS = {
  never: { what: 'Nobody holds the tool.', again: HOLD },
  held: { what: 'Nobody holds the tool.', again: HOLD },
  let_go: { what: 'You let go of the tool.', again: HOLD },
  silent: { what: 'The page did not answer in time: it was too slow, or hidden.', again: 'Let go, then press on the tool again.' },
  page_gone: { what: 'The page that was in control was closed.', again: HOLD },
};

const ENDS = {
  over: { what: 'The run is over.', again: 'Start it again.' },
  stopped: { what: 'STOP was pressed.', again: 'Start the run again.' },
  interrupted: { what: 'The run was interrupted.', again: 'Start it again.' },
  stalled: { what: 'The watchdog ended the run: a node did not come back.', again: 'Start the run again.' },
  failed: { what: 'The run has failed.', again: 'Read why above, then start it again.' },
};

/**
 * @param {object} now
 * @param {string} now.engagement @param {string} now.cause of the safety gate
 * @param {string} [now.hold] the dead-man button of the mouse; none where a page does not lead the device, or it is not known yet
 * @param {string} [now.phase] of the run
 * @param {string[]} [now.stalled] the nodes that do not answer
 * @param {'me' | 'other' | 'nobody'} now.control who leads
 * @param {boolean} now.connected
 * @param {string} [now.end] why the run ended
 * @returns {Release | null} null while the force is not kept out
 */
export function release_of({ engagement, cause, hold, phase, stalled = [], control, connected, end }) {
  if (end) return ENDS[end] ?? ENDS.over;
  if (!connected) return { what: 'The connection is lost.', again: 'Press “Connect again”, take control, and press on the tool.' };
  if (cause === 'none' || engagement === 'engaged') return null;
  if (cause === 'dead_man' && hold !== undefined) {
    if (control === 'other') return { what: 'Another page is in control.', again: 'Close that page, then press “Take control”.' };
    if (control === 'nobody') return { what: hold === 'page_gone' ? HOLDS.page_gone.what : 'Nobody is in control.', again: 'Press “Take control”, then press on the tool and hold it.' };
    return HOLDS[hold] ?? HOLDS.held;
  }
  if (cause === 'stale' && stalled.length) return { what: `The watchdog sees that ${stalled.join(', ')} ${stalled.length > 1 ? 'do' : 'does'} not answer.`, again: ITSELF };
  if (cause === 'not_permitted' && phase === 'stopping') return { what: 'The run is stopping.', again: 'Start it again.' };
  return CAUSES[cause] ?? { what: `The safety gate keeps the force out (${cause}).`, again: ITSELF };
}

/** The words of the server's enumerations that this page has no sentence for. @param {object} hello @returns {string[]} */
export function without_words({ causes = [], holds = [], ends = [] }) {
  return [...causes.filter((word) => word !== 'none' && !CAUSES[word]), ...holds.filter((word) => !HOLDS[word]), ...ends.filter((word) => !ENDS[word])];
}
