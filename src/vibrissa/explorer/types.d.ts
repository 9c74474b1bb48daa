// Types of solver and page. Lengths are in units of L, forces of E·I0/L², moments of E·I0/L; angles are in rad.

/* The rod and one state of it: solver/rod. */

/** Whether the rod touches the surface with its tip, or along a line. */
type Contact = "point" | "line";

type Rod = import("./solver/rod/rod.js").Rod;

/** How a rod is mounted: docs/mounting.md. */
interface Mounting {
  angle: number; // inclination β of the clamp, positive where the rod leans back
  compliance: number; // rotational compliance c of the clamp, in L/(E·I0)
  curvature: number[]; // coefficients of the powers of s in κ0·L
  stage: number; // angle δ of the clamp's path to the surface
  making?: Making; // by default solid and of one material
}

/** How a rod is made, apart from its taper. */
interface Making {
  powers: number[]; // coefficients of s, s², … in E(s)/E(0) = 1 + …
  bore: number; // diameter of a bore over that of the base
}

/** A solved state. */
interface State {
  unknowns: Float64Array; // slopes at the nodes, then fx, fy and s_c
  contact: Contact;
  offset: number; // position of the tip along the surface, relative to the clamp
  height: number; // height of the contact point above the clamp
  fx: number;
  fy: number;
  m: number; // bending moment at the clamp
  phi1: number; // slope at the contact point
  sc: number; // arc length of the contact point
}

/** A deformed rod, point by point, with its clamp at the origin. */
type Shape = Record<"s" | "x" | "y" | "phi", Float64Array>;

/** Legendre coefficients of the slope φ and of dx/dτ and dy/dτ of a rod. */
type Series = Record<"phi" | "along" | "up", Float64Array>;

/** Room of a rod (L): negative where its shape is inadmissible, infinite where no part of it is near a limit. */
interface Clearance {
  clamp: number; // above the level of the clamp
  surface: number; // below the surface, away from the contact point
  itself: number; // between two parts of the rod
}

/** A point of a rod as seen from an earlier part: turn of the rod between them (rad), distance, negative where it is past that part. */
interface Facing {
  turn: number;
  distance: number;
}

/** Quantities of a state at the nodes; `natural` and `turned` have one more entry, at the contact point. */
interface NodeValues {
  kernel: Float64Array;
  natural: Float64Array; // slope of the unloaded rod
  arc: Float64Array; // ds/dτ
  sin: Float64Array;
  cos: Float64Array;
  gradient: Float64Array; // dm/dτ
  turned: Float64Array; // decrease of the slope by the bending moment
  height: number;
  reach: number;
}

/** The linear condition (E3): factors of its quantities, 0 by default, and its value. */
interface Condition {
  offset?: number;
  fx?: number;
  fy?: number;
  sc?: number;
  phi1?: number;
  value: number;
}

/** Where the contact point may be: height − tilt·offset = level, (M6) of docs/mounting.md. */
interface Surface {
  level: number;
  tilt: number;
}

/** Conditions that close the equations of a state. */
interface Closure {
  surface: Surface;
  contact: Contact;
  condition: Condition;
}

/** The factors L and U of a square matrix, row by row, and its rows in the order of their pivots. */
interface Factors {
  size: number;
  rows: Float64Array;
  order: Int32Array;
  sign: number; // sign of the permutation `order`
}

/** Nodes and weights, with matrices that integrate the polynomial through values at the nodes. */
interface Rule {
  count: number;
  nodes: Float64Array;
  weights: Float64Array;
  fromStart: Float64Array; // integrals from 0 to each node, row by row, and to 1: the weights
  toCoefficients: Float64Array; // values at the nodes to Legendre coefficients
  // For each power p of τ: values are integrated from each node to 1, multiplied by τ^p, and integrated
  // from 0 to each node and to 1.
  kernels: Float64Array[];
}

/* A path of states: solver/beginning.js, solver/arm.js, solver/path.js. */

/** A rod below a surface; by default its mounting is ideal. */
interface Given {
  theta: number;
  eta: number;
  contact: Contact;
  round: boolean; // whether the rod can leave its plane
  mounting?: Mounting;
}

/** The state in which a period begins, and the one in the ideal mounting, which gives the units of steps. */
interface Beginning {
  state: State;
  ideal: State;
}

/** A state in a mounting with a share of all deviations from the ideal one. */
interface Partly {
  state: State;
  share: number;
}

/** The rod, contact and surface to which a path belongs. */
interface Branch {
  rod: Rod;
  eta: number;
  model: Contact;
  round: boolean;
  x1: number; // offset of the first state
  way: number; // displacement along the surface per displacement of the clamp
  surface: Surface;
  scale: number; // offset of the first state in the ideal mounting
  force: number; // force of that state
}

/** A state on a path, with the direction in which the path goes on. */
interface Knot {
  state: State;
  change: Float64Array; // derivative of the unknowns along the path
  offsetChange: number; // derivative of the offset along the path
  direction: number[]; // unit vector of the derivatives of offset, fx, fy and s_c, in their units
  step: number; // length along the direction of the knot before; 0 after a kink
  exact: boolean; // whether its state is a landmark, solved to rounding error
  factors: Factors; // of the Jacobian, for states nearby
}

type End = "swings" | "snaps" | "lifts" | "inadmissible" | "lost";

/** How, where and why an arm ends. */
interface Ending {
  end: End;
  knot: Knot | null;
  why?: string;
}

/** A path from α = 0, its first knot, to one side. */
interface Arm {
  branch: Branch;
  knots: Knot[];
  end: End;
  why: string;
}

interface Path {
  branch: Branch;
  pushed: Arm;
  pulled: Arm;
  lock: Knot | null; // the critical state; null where −tan α has no maximum
  muLock: number; // largest demand; infinite if the tip lifts off while pushed forward; NaN if the path ends before
  x0End: number; // displacement up to which a pushed tip may stick
  x0Pulled: number; // displacement at the end of the pulled arm, negative
}

/** A path as a table, dense enough to be drawn. */
type Curve = Record<"x0" | "fx" | "fy" | "m" | "energy" | "demand", number[]>;

/** Limits between the regimes at one taper. */
interface Division {
  theta: number;
  lock: number; // μ_lock; NaN where it is not known
  touch: number; // friction at which the slope of the tip is zero; NaN where it never is
}

/* The clamp moves: solver/motion.js. */

/** Where a slip ends: at α = 0, where kinetic friction holds, or where it has consumed the energy. */
type SlipLaw = "free" | "kinetic" | "energy";

interface Friction {
  mu0: number;
  ratio: number; // kinetic over static
  law: SlipLaw;
}

/** Why sticking ends at a displacement. */
type Limit = End | "slips" | "slips back";

/** Displacements x0 at which sticking ends on a path with given friction. */
interface Sticking {
  path: Path;
  friction: Friction;
  ahead: number; // demand −tan α at which the tip slips forward: μ0 on a plane
  behind: number; // demand at which it slips backward, −μ0 on a plane
  high: number; // where sticking ends when x0 grows
  highBy: Limit;
  low: number; // where sticking ends when x0 falls
  lowBy: Limit;
  touch: number; // where the tip's slope is zero; NaN where it never is
  lock: number; // at the critical state; NaN if the tip slips forward
}

/** Where clamp and tip are. */
interface Place {
  clamp: number;
  x0: number; // displacement of the clamp since α = 0
  side: number; // 1 where the tip is ahead of the clamp, -1 where the rod trails behind it
}

type Passed = "lies down" | "peels off" | "passes through" | "comes free" | "locks" | "unlocks";

/** An event while the clamp moves. */
interface Incident {
  what: Limit | "flies off" | "is lost" | "slides along" | Passed;
  clamp: number;
  x0: number;
  rest: number; // displacement after the event
  side: number; // side of the tip after the event, as in Place
  slid?: { from: number; to: number; state: State }; // places of a tip that slips on a wave, and the state before
}

/** The place to which a move leads, and the events on the way. */
interface Move {
  place: Place;
  events: Incident[];
}

/* A surface with a wave: solver/wave.js. */

/** Heights amplitude·sin(2πx/wavelength) of a surface, positive towards the clamp. */
interface Wave {
  amplitude: number;
  wavelength: number;
}

/** A surface with a wave, and the rod on it, with the height of the plane without the wave. */
interface Ground {
  given: Required<Given>;
  wave: Wave;
  friction: Friction;
  nodes: number; // that were enough for a similar rod
}

/** A tip that sticks at a place of a wave. */
interface Tip {
  sticking: Sticking; // on the path of the rod at the height of this place
  contact: number; // this place
  place: Place;
}

/** A rod whose tip begins to slip. */
interface Slipping {
  rod: Rod;
  state: State;
  contact: number;
}

/** What is left until a tip slips: a linear function of the forces. */
type Margin = Record<"fx" | "fy", number>;

/** A place on the way of a slide. */
interface Spot {
  distance: number; // from the start of the slide
  contact: number;
  state: State;
  normal: number; // normal force times 1/cos γ
  net: number; // what drives the tip beyond kinetic friction, times 1/cos γ
  left: number; // what ends the slide where it falls to 0
}

interface Slide {
  start: Spot | null;
  cell: number; // distance of the spots
  spotAt: (distance: number, near: Spot) => Spot | null;
}

/** Where a move on a wave leads; without a tip the message says why. */
interface MoveOn {
  tip: Tip | null;
  events: Incident[];
  message: string;
}

/* The page: view. */

type Explorer = import("./view/explorer.js").Explorer;
type StickingPlot = import("./view/panels.js").StickingPlot;
type RegimePlot = import("./view/panels.js").RegimePlot;

type Attributes = Record<string, string | number>;

/** A drawing as text. */
interface Drawing {
  text: string;
  width: number;
  height: number;
}

/** Values at the edges of a plot. */
type Frame = Record<"left" | "right" | "low" | "high", number>;

interface Point {
  x: number;
  y: number;
}

/** Points of a line. */
type Line = Record<"x" | "y", Float64Array>;

type NumberKey = "theta" | "eta" | "mu0" | "dx0" | "ratio" | "modulus" | "diameter" | "length" | MountingKey | keyof Wave;
type MountingKey = "beta" | "compliance" | "kappa0" | "kappa1" | "stiffening" | "bore" | "delta";

/** Settings of a user: angles in degrees, E in GPa, diameter and length in mm. */
interface Settings extends Record<NumberKey, number> {
  contact: Contact;
  section: "round" | "planar";
  law: SlipLaw;
  units: "none" | "si";
  speed: "slow" | "normal" | "fast";
  labels: "on" | "off";
}

/** The rod of a sensor, which turns units of L and E·I0 into SI units. */
type Whisker = Pick<Settings, "modulus" | "diameter" | "length" | "bore">;

interface NumberField {
  key: NumberKey;
  symbol: string;
  label: string;
  min: number;
  max: number;
  step: number;
  unit?: string;
  help: string;
}

interface ChoiceField {
  key: Exclude<keyof Settings, NumberKey>;
  label: string;
  words: [string, string][]; // the value, and its name on the page
  help: string;
}

/** A named choice of settings: Preset in page.py. */
interface Preset {
  name: string;
  note: string;
  settings: Partial<Settings>;
  clamp: number;
  play: boolean;
  recording: Recording | null;
}

/** All that a link restores. */
interface Shared {
  settings: Settings;
  clamp: number;
  x0: number; // NaN if the clamp is to be moved there from 0
  tip: number; // position of the tip on a wave; NaN on a plane, or if the clamp is to be moved there from 0
  side: number;
  pins: Settings[]; // rods of the pinned curves
}

/** State and loads at a place. */
interface Reading extends Place {
  contact: number; // position of the tip along the surface
  state: State;
  fx: number;
  fy: number;
  m: number;
  phi1: number;
  sc: number;
  demand: number;
  energy: number;
}

/** A measured recording; a missing value is NaN. */
interface Recording extends Record<"clamp" | "fx" | "fy" | "m", number[]> {
  name: string;
}

type Quantity = "length" | "force" | "moment" | "energy" | "number" | "angle";

interface Units {
  scale: Record<Quantity, number>; // factors from nondimensional values to values in these units
  name: Record<Quantity, string>;
}

/** A rod with a pinned curve. */
interface Pin {
  settings: Settings;
  curve: Curve;
  muLock: number;
}

/** All that the plots show. */
interface View {
  settings: Settings;
  units: Units;
  sticking: Sticking;
  curve: Curve;
  now: Reading;
  trace: Reading[];
  rests: number[]; // places at which the last slips on a wave ended
  slipsInWave: number;
  recording: Recording | null;
  divisions: Division[];
  pins: Pin[];
}

/** The last jump of the tip, which stays visible. */
interface Jump {
  before: Line; // the rod before it
  part: number; // what part of the way from there the rod has gone; 1 if its states on the way are drawn
  from: number; // the contact point before and after
  to: number;
  text: string; // length of the jump
}

/** All that the drawing of the rod shows. */
interface Scene {
  settings: Settings;
  now: Reading;
  shape: Shape;
  facing: number; // side of the tip; between -1 and 1 while the plane of the rod turns
  jump: Jump | null;
  first: Shape; // shape at α = 0
  length: number; // factor from lengths in L to those on the ruler
  unit: number; // force whose arrow is as long as a quarter of L
  slides: boolean; // whether the tip slips
}
