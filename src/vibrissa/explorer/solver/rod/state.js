// Quantities of a solved state of the rod.

/** Magnitude of the contact force. @type {(state: State) => number} */
export function force(state) {
  return Math.hypot(state.fx, state.fy);
}

/** Inclination α of the contact force. @type {(state: State) => number} */
export function inclination(state) {
  return Math.atan2(state.fx, -state.fy);
}

/** Friction −tan α required to stick; negative where the clamp pulls. @type {(state: State) => number} */
export function demand(state) {
  return state.fx / state.fy;
}
