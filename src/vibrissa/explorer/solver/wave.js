// A tip on a wave: where it sticks, slips and comes to rest. See docs/texture.md.

import { displacement } from "./arm.js";
import { isMirrored, limitOf, MOST_SLIDES, passed, SAME } from "./motion.js";
import { bracketedRoot } from "./numerics/roots.js";
import { HEIGHTS, rises, solvedPath, stateAt, touch } from "./path.js";
import { solvedState, tangent } from "./rod/newton.js";

/** Cells of a slide: parts of a wavelength, and the longest cell (L). */
const CELLS_PER_WAVE = 64;
const LONGEST_CELL = 2e-3;
/** The longest slide (L). */
const LONGEST_SLIDE = 2;
/** Accuracy of the length of a slide (L); travel of the clamp (L) below which slips are not followed one by one. */
const EXACT_LENGTH = 1e-13;
const SHORTEST_PERIOD = 1e-6;
/** Part of the friction by which rounding errors may exceed it. */
const FULL = 1e-9;

/** Height of a wave, positive towards the clamp. @type {(wave: Wave, x: number) => number} */
export function heightOf({ amplitude, wavelength }, x) {
  return amplitude * Math.sin((2 * Math.PI * x) / wavelength);
}

/** Slope h' of a wave. @type {(wave: Wave, x: number) => number} */
export function slopeOf({ amplitude, wavelength }, x) {
  const number = (2 * Math.PI) / wavelength;
  return amplitude * number * Math.cos(number * x);
}

/**
 * Put the tip where a scan begins: no tangential force acts. Returns a message if there is no such place.
 * @type {(ground: Ground, clamp: number) => Tip | string}
 */
export function begunOn(ground, clamp) {
  const { path, message } = solvedPath(ground.given, ground.nodes);
  if (!path) return message;
  const start = { rod: path.branch.rod, state: path.pushed.knots[0].state, contact: clamp + path.branch.x1 };
  const free = { ...ground, friction: { ...ground.friction, law: /** @type {SlipLaw} */ ("free") } };
  const rest = slipOn(free, clamp, 1, start);
  return rest ? tipOn(ground, clamp, rest, 1) : "no place was found at which the tip can begin: try a flatter wave";
}

/**
 * The tip at a place of a wave, with the path of the rod at the height there; a message if it has none.
 * @type {(ground: Ground, clamp: number, contact: number, side: number) => Tip | string}
 */
export function tipOn(ground, clamp, contact, side) {
  const { given, wave, friction, nodes } = ground;
  const eta = given.eta - heightOf(wave, contact);
  if (!(eta > HEIGHTS.low && eta < HEIGHTS.high)) {
    return "the wave leaves the heights at which a period can begin: try a smaller η or amplitude";
  }
  const { path, message } = solvedPath({ ...given, eta }, nodes);
  if (!path) return message;
  const displaced = path.branch.x1 + side * (clamp - contact);
  // A rod that has just buckled laterally is at the end of its path, up to rounding.
  const x0 = Math.min(path.x0End, Math.max(path.x0Pulled, displaced));
  const isKnown = Math.abs(x0 - displaced) < SAME;
  const sticking = isKnown ? stickingOn(path, friction, side * slopeOf(wave, contact), x0) : null;
  return sticking ? { sticking, contact, place: { clamp, x0, side } } : "the tip has left the states of the rod: try a flatter wave";
}

/**
 * Where sticking ends on a slope h', for a tip at x0: forward where −tan α = tan(atan μ0 + atan h'), and backward
 * where tan α = tan(atan μ0 − atan h'). A tip that friction does not hold has no room: then both limits are x0.
 * @type {(path: Path, friction: Friction, slope: number, x0: number) => Sticking | null}
 */
export function stickingOn(path, friction, slope, x0) {
  const { mu0 } = friction;
  const now = stateAt(path, x0);
  if (!now) return null;
  // Both margins are linear in the forces: that of T + μ0·N, and that of μ0·N − T.
  const forward = { fx: 1 - mu0 * slope, fy: -slope - mu0 };
  const backward = { fx: -1 - mu0 * slope, fy: slope - mu0 };
  const ahead = placesWithout(path, forward);
  const exits = [...ahead, ...placesWithout(path, backward)];
  const holds = [forward, backward].every((margin) => left(margin, now) >= -FULL * mu0 * Math.abs(now.fy));
  const [above, below] = holds ? [exits.filter((at) => at > x0), exits.filter((at) => at < x0)] : [[x0], [x0]];
  const [high, low] = [Math.min(...above), Math.max(...below)];
  const touches = touch(path);
  const [cone, turn] = [Math.atan(mu0), Math.atan(slope)];
  return {
    path,
    friction,
    ahead: cone + turn < Math.PI / 2 ? Math.tan(cone + turn) : Infinity,
    behind: cone - turn < Math.PI / 2 ? -Math.tan(cone - turn) : -Infinity,
    high: Math.min(high, path.x0End),
    highBy: high <= path.x0End ? "slips" : path.pushed.end,
    low: Math.max(low, path.x0Pulled),
    lowBy: low >= path.x0Pulled ? "slips" : "lost",
    touch: touches ? displacement(path.branch, touches) : NaN,
    lock: ahead.some((at) => at > x0) || !path.lock ? NaN : displacement(path.branch, path.lock.state),
  };
}

/** What is left of a margin. @type {(margin: Margin, state: State) => number} */
function left({ fx, fy }, state) {
  return fx * state.fx + fy * state.fy;
}

/** Displacements at which a margin vanishes. @type {(path: Path, margin: Margin) => number[]} */
function placesWithout({ branch, pushed, pulled }, margin) {
  const condition = { ...margin, value: 0 };
  const states = [pushed, pulled].flatMap((arm) => [
    ...rises(arm, (state) => -left(margin, state), condition),
    ...rises(arm, (state) => left(margin, state), condition),
  ]);
  return states.map((state) => displacement(branch, state));
}

/**
 * Find where a tip that begins to slip comes to rest, with the clamp at rest: its place, or null if it does not in
 * known states.
 * @type {(ground: Ground, clamp: number, side: number, start: Slipping) => number | null}
 */
export function slipOn(ground, clamp, side, { rod, state, contact }) {
  const { mu0, law } = ground.friction;
  const { factors } = tangent(rod, state, { level: state.height, tilt: 0 }, { offset: 1, value: state.offset });
  /** @type {(place: number, near: State) => State | null} */
  const stateOn = (place, near) => stateAbove(ground, rod, clamp, side, place, near, factors);
  let [at, now] = [contact, state];
  for (let slide = 0; slide < MOST_SLIDES; slide += 1) {
    const end = endOf(slideFrom(ground, side, at, now, stateOn));
    if (!end) return null;
    [at, now] = [end.spot.contact, end.spot.state];
    const { tangential, normal } = forcesOn(ground.wave, side, at, now);
    const holds = law === "free" ? !end.landed : Math.abs(tangential) <= mu0 * normal * (1 + FULL);
    if (holds) return at;
  }
  return null;
}

/**
 * The state of a rod whose tip is at a place of a wave; null if it is not found.
 * @type {(ground: Ground, rod: Rod, clamp: number, side: number, place: number, near: State, factors?: Factors)
 *   => State | null}
 */
export function stateAbove({ given, wave }, rod, clamp, side, place, near, factors) {
  const surface = { level: given.eta - heightOf(wave, place), tilt: 0 };
  const condition = { offset: 1, value: side * (place - clamp) };
  return solvedState(rod, near.unknowns, { surface, contact: "point", condition }, factors);
}

/**
 * Forces on a tip, times 1/cos γ: along the surface, and normal to it.
 * @type {(wave: Wave, side: number, contact: number, state: State) => { tangential: number, normal: number }}
 */
function forcesOn(wave, side, contact, { fx, fy }) {
  const slope = side * slopeOf(wave, contact);
  return { tangential: fx - slope * fy, normal: -slope * fx - fy };
}

/**
 * A slide in the direction of the tangential force, cell by cell. It ends where `left` falls to 0: what drives the tip
 * beyond kinetic friction, or by the law "energy" the energy that the slide has gained.
 * @type {(ground: Ground, side: number, from: number, state: State,
 *   stateOn: (place: number, near: State) => State | null) => Slide}
 */
function slideFrom({ wave, friction }, side, from, state, stateOn) {
  const { mu0, ratio, law } = friction;
  const kinetic = law === "free" ? 0 : ratio * mu0;
  const way = forcesOn(wave, side, from, state).tangential <= 0 ? 1 : -1;
  /** @type {(distance: number, near: State) => Spot | null} */
  const balanced = (distance, near) => {
    const contact = from + side * way * distance;
    const now = distance === 0 ? near : stateOn(contact, near);
    if (!now) return null;
    const { tangential, normal } = forcesOn(wave, side, contact, now);
    const net = -way * tangential - kinetic * normal;
    return { distance, contact, state: now, normal, net, left: net };
  };
  /** @type {(distance: number, near: Spot) => Spot | null} */
  const gaining = (distance, near) => {
    const [middle, spot] = [0.5 * (near.distance + distance), distance].map((at) => balanced(at, near.state));
    if (!middle || !spot) return null;
    // Simpson's rule.
    return { ...spot, left: near.left + ((distance - near.distance) / 6) * (near.net + 4 * middle.net + spot.net) };
  };
  const start = balanced(0, state);
  return {
    start: start && law === "energy" ? { ...start, left: 0 } : start,
    cell: Math.min(wave.wavelength / CELLS_PER_WAVE, LONGEST_CELL),
    spotAt: law === "energy" ? gaining : (distance, near) => balanced(distance, near.state),
  };
}

/**
 * Where a slide ends, and whether the tip has flown there: a tip that lifts off lands at the next place at which the
 * surface pushes it, without velocity. null if the slide leaves the states of the rod.
 * @type {(slide: Slide) => { spot: Spot, landed: boolean } | null}
 */
function endOf(slide) {
  let [before, from, landed] = [slide.start, slide.start, false];
  while (before && from && from.distance < LONGEST_SLIDE) {
    const to = slide.spotAt(from.distance + slide.cell, from);
    if (!to) return null;
    // Where the tip lifts off or lands.
    const turn = to.normal > 0 === landed ? spotWhere(slide, from, to, "normal") : null;
    const stop = landed ? null : stopBetween(slide, before, from, to);
    if (stop && !(turn && turn.distance < stop.distance)) return { spot: stop, landed };
    if (landed && turn) return { spot: turn, landed };
    landed ||= to.normal <= 0;
    [before, from] = [from, to];
  }
  return null;
}

/**
 * The first spot up to `to` at which nothing is left, also in a dip between two cells; null if there is none.
 * @type {(slide: Slide, before: Spot, from: Spot, to: Spot) => Spot | null}
 */
function stopBetween(slide, before, from, to) {
  if (from.left < before.left && from.left < to.left) {
    // The lowest point of the parabola through the three spots.
    const [down, up] = [before.left - from.left, to.left - from.left];
    const lowest = from.distance + (0.5 * slide.cell * (down - up)) / (down + up);
    const near = lowest < from.distance ? before : from;
    const dip = slide.spotAt(lowest, near);
    if (dip && dip.left <= 0) return spotWhere(slide, near, dip, "left");
  }
  return to.left <= 0 ? spotWhere(slide, from, to, "left") : null;
}

/** The spot between two others at which a number vanishes. @type {(slide: Slide, from: Spot, to: Spot, name: "left" | "normal") => Spot | null} */
function spotWhere({ spotAt }, from, to, name) {
  /** @param {number} distance */
  const value = (distance) => spotAt(distance, from)?.[name] ?? NaN;
  // By the law "energy" nothing is left at the start, either.
  const first = name === "left" ? Math.max(from.left, Number.MIN_VALUE) : from.normal;
  const root = bracketedRoot(value, from.distance, to.distance, first, to[name], EXACT_LENGTH);
  return Number.isNaN(root) ? null : spotAt(root, from);
}

/**
 * Move the clamp up to the end of a period, or to `clamp`. If the move is `stepped`, the tip slips after the step that
 * passes the onset; otherwise at the exact onset.
 * @type {(ground: Ground, tip: Tip, clamp: number, stepped: boolean) => MoveOn}
 */
export function movedOn(ground, tip, clamp, stepped) {
  const { sticking, contact, place } = tip;
  const { path, low, high } = sticking;
  const { side } = place;
  const aim = place.x0 + side * (clamp - place.clamp);
  const limit = low === high ? { x0: low, by: /** @type {Limit} */ ("slips") } : limitOf(sticking, place.x0, aim);
  const events = passed(sticking, place, limit ? limit.x0 : aim);
  if (!limit) return { tip: { ...tip, place: { ...place, clamp, x0: aim } }, events, message: "" };
  const slips = limit.by === "slips";
  const whole = slips && (stepped || Math.abs(limit.x0 - place.x0) < SHORTEST_PERIOD);
  const at = whole ? clamp : place.clamp + side * (limit.x0 - place.x0);
  const x0 = Math.min(path.x0End, Math.max(path.x0Pulled, whole ? aim : limit.x0));
  const state = stateAt(path, x0);
  // A step that has left the computed states takes the tip along.
  const from = contact + (whole ? side * (aim - x0) : 0);
  const rest = slips && state ? slipOn(ground, at, side, { rod: path.branch.rod, state, contact: from }) : null;
  const mirrored = limit.by === "swings" && isMirrored(path);
  /** @type {Incident} */
  const event = { what: slips && rest === null ? "is lost" : limit.by, clamp: at, x0, rest: x0, side };
  // The tip of an ideally mounted rod stays where it is when the rod buckles laterally.
  const next = mirrored ? tipOn(ground, at, contact, -side)
    : rest === null ? begunOn(ground, at) : tipOn(ground, at, rest, side);
  if (typeof next === "string") return { tip: null, events, message: next };
  const slid = state && rest !== null ? { from, to: next.contact, state } : undefined;
  events.push({ ...event, rest: next.place.x0, side: next.place.side, slid });
  return { tip: next, events, message: "" };
}
