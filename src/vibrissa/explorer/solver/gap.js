// How near a rod comes to itself: where it begins to cross itself, its tip or a part that runs back touches it.

import { bracketedRoot } from "./numerics/roots.js";
import { CLAMP_SLOPE, tailOf } from "./rod/mounting.js";

/** Number of points between which a rod is examined, at equal distances along it. */
const PARTS = 120;
const EVENLY = Float64Array.from({ length: PARTS + 1 }, (_, i) => i / PARTS);
/** A turn (rad) between two parts up to which they do not face each other: they do at half a circle. */
const HALF_TURN = Math.PI - 0.3;
/** How much larger a turn may be than that between nodes (rad); and number of points of a tail that are examined. */
const MORE = 0.05;
const TAIL_PLACES = 16;
/** Distance (L) along the rod, from a point that is nearly the nearest, in which the nearest point is sought. */
const WITHIN = 3 / PARTS;
/** Accuracy of places on the rod (L), at which distances are stationary. */
const PLACED = 1e-10;

/**
 * Smallest distance (L) between two parts of a rod that face each other: negative where they overlap, infinite if
 * no parts do. The distance of a point of the rod from an earlier part is smallest at the tip, or where both are
 * parallel.
 * @type {(rod: Rod, state: State) => number}
 */
export function gap(rod, state) {
  if (turnOf(rod, state) + MORE < HALF_TURN) return Infinity;
  const series = rod.series(state);
  const shape = rod.shape(state, EVENLY, series);
  const facing = Array.from(EVENLY, (_, j) => nearestBefore(shape, j));
  const distances = facing.map((i, j) => (i < 0 ? Infinity : facingAt(shape, i, shape, j).distance));
  /** @type {(s: number) => Shape} */
  const at = (s) => rod.shape(state, Float64Array.of(s), series);
  let least = Infinity;
  for (let j = 1; j <= PARTS; j += 1) {
    const after = j < PARTS ? distances[j + 1] : Infinity;
    if (facing[j] < 0 || distances[j] > Math.min(distances[j - 1], after)) continue;
    least = Math.min(least, smallestNear(at, j, facing[j]));
  }
  return least;
}

/** Largest turn between two parts of a rod. @type {(rod: Rod, state: State) => number} */
function turnOf({ nodes, mounting }, { unknowns, contact, m, sc }) {
  const { angle, compliance } = mounting;
  const slopes = [CLAMP_SLOPE + angle + compliance * m, ...unknowns.subarray(0, nodes)];
  if (contact === "line") {
    const parts = Array.from({ length: TAIL_PLACES }, (_, k) => (1 + k) / TAIL_PLACES);
    slopes.push(...parts.map((part) => tailOf(mounting, sc, sc + (1 - sc) * part).turn));
  }
  return Math.max(...slopes) - Math.min(...slopes);
}

/**
 * Smallest distance of points next to point j of a rod from its part around point i; infinite if they do not face it.
 * @type {(shapeAt: (s: number) => Shape, j: number, i: number) => number}
 */
function smallestNear(shapeAt, j, i) {
  /** @param {number} s */
  const facing = (s) => facingFrom(shapeAt, s, EVENLY[i]);
  /** The distance falls where this is positive. @param {number} s */
  const beyondParallel = (s) => (facing(s)?.turn ?? NaN) - Math.PI;
  const [low, high] = [EVENLY[j - 1], EVENLY[Math.min(j + 1, PARTS)]];
  const [before, after] = [beyondParallel(low), beyondParallel(high)];
  const inside = before > 0 && after < 0;
  const s = inside ? bracketedRoot(beyondParallel, low, high, before, after, PLACED) : EVENLY[j];
  return facing(s)?.distance ?? Infinity;
}

/**
 * The point nearest to point j of those before it from which the rod turns by half a circle; -1 if there is none.
 * @type {(shape: Shape, j: number) => number}
 */
function nearestBefore({ x, y, phi }, j) {
  let [nearest, least] = [-1, Infinity];
  for (let i = 0; i < j; i += 1) {
    if (Math.abs(phi[j] - phi[i]) < HALF_TURN) continue;
    const square = (x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2;
    if (square < least) [nearest, least] = [i, square];
  }
  return nearest;
}

/**
 * The point at s as seen from the nearest point of the rod around another place; null if none faces it.
 * @type {(shapeAt: (s: number) => Shape, s: number, around: number) => Facing | null}
 */
function facingFrom(shapeAt, s, around) {
  const point = shapeAt(s);
  /** How far ahead the point is of a place on the rod. @param {number} place */
  const ahead = (place) => {
    const { x, y, phi } = shapeAt(place);
    return Math.cos(phi[0]) * (point.x[0] - x[0]) + Math.sin(phi[0]) * (point.y[0] - y[0]);
  };
  const [low, high] = [Math.max(0, around - WITHIN), Math.min(s, around + WITHIN)];
  const [first, last] = [ahead(low), ahead(high)];
  if (!(first > 0 && last < 0)) return null;
  const foot = bracketedRoot(ahead, low, high, first, last, PLACED);
  const found = facingAt(shapeAt(foot), 0, point, 0);
  return found.turn > HALF_TURN ? found : null;
}

/**
 * Turn of the rod from point i of a shape to point j of another, and distance of the second from the tangent of the
 * first, positive on the side to which the rod turns.
 * @type {(one: Shape, i: number, other: Shape, j: number) => Facing}
 */
function facingAt(one, i, other, j) {
  const turn = other.phi[j] - one.phi[i];
  const [cos, sin] = [Math.cos(one.phi[i]), Math.sin(one.phi[i])];
  const aside = cos * (other.y[j] - one.y[i]) - sin * (other.x[j] - one.x[i]);
  return { turn: Math.abs(turn), distance: Math.sign(turn) * aside };
}
