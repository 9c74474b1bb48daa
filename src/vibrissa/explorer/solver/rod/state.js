// A solved state of the rod, and what is read off it.

/** @typedef {"point" | "line"} Contact Whether the rod touches the surface with its tip or along a line. */

/**
 * A solved state: lengths in units of L, forces of E·I0/L², moments of E·I0/L, angles in rad.
 * @typedef {object} State
 * @property {Float64Array} unknowns Slopes at the nodes, then fx, fy and s_c.
 * @property {Contact} contact
 * @property {number} offset Position of the tip along the surface, seen from the clamp.
 * @property {number} height Height of the contact point over the clamp.
 * @property {number} fx
 * @property {number} fy
 * @property {number} m Moment at the clamp.
 * @property {number} phi1 Slope at the contact point.
 * @property {number} sc Arc length of the contact point.
 */

/** Magnitude of the contact force. @type {(state: State) => number} */
export function force(state) {
  return Math.hypot(state.fx, state.fy);
}

/** Inclination α of the contact force. @type {(state: State) => number} */
export function inclination(state) {
  return Math.atan2(state.fx, -state.fy);
}

/**
 * Friction coefficient −tan α that the tip needs to stick; negative where the clamp pulls.
 * @type {(state: State) => number}
 */
export function demand(state) {
  return state.fx / state.fy;
}
