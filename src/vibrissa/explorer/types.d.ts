// What solver and page exchange. Lengths are in units of L, forces of E·I0/L², moments of E·I0/L, angles in rad.

/* The rod and one state of it: solver/rod. */

/** Whether the rod touches the surface with its tip, or along a line. */
type Contact = "point" | "line";

type Rod = import("./solver/rod/rod.js").Rod;

/** How a rod is mounted: docs/mounting.md. */
interface Mounting {
  angle: number; // inclination β of the clamp, positive where the rod leans back
  compliance: number; // turn c of the clamp per moment, in L/(E·I0)
  curvature: number[]; // coefficients of the powers of s in κ0·L
  stage: number; // angle δ of the clamp's way to the surface
}

/** A solved state. */
interface State {
  unknowns: Float64Array; // slopes at the nodes, then fx, fy and s_c
  contact: Contact;
  offset: number; // position of the tip along the surface, seen from the clamp
  height: number; // of the contact point over the clamp
  fx: number;
  fy: number;
  m: number; // at the clamp
  phi1: number; // slope at the contact point
  sc: number; // arc length of the contact point
}

/** A deformed rod, point by point, with its clamp at the origin. */
type Shape = Record<"s" | "x" | "y" | "phi", Float64Array>;

/** What a state is made of at the nodes; two of its parts have one entry more, at the contact point. */
interface NodeValues {
  kernel: Float64Array;
  natural: Float64Array; // slope of the unloaded rod, and at the contact point
  arc: Float64Array; // ds/dτ
  sin: Float64Array;
  cos: Float64Array;
  gradient: Float64Array; // dm/dτ
  turned: Float64Array; // slope that the moment takes from the rod, and at the contact point
  height: number;
  reach: number;
}

/** Factors of the condition (E3), which is linear, and its value; what is not named has no part in it. */
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

/** What closes the equations of a state. */
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
  sign: number; // of that order
}

/** Nodes and weights with what integrates a polynomial through the nodes. */
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

/** The state in which a period begins, and that of the ideal mounting, in whose units steps count. */
interface Beginning {
  state: State;
  ideal: State;
}

/** A state with a share of all deviations of a mounting. */
interface Partly {
  state: State;
  share: number;
}

/** What a path belongs to. */
interface Branch {
  rod: Rod;
  eta: number;
  model: Contact;
  round: boolean;
  x1: number; // offset of the first state
  surface: Surface;
  scale: number; // offset of the first state in the ideal mounting
  force: number; // force of that state
}

/** A state on a path, with the direction in which the path goes on. */
interface Knot {
  state: State;
  change: Float64Array; // derivative of the unknowns along the path
  offsetChange: number; // the same of the offset
  direction: number[]; // the same of offset, fx, fy and s_c, in their units; of length 1
  step: number; // length along the direction of the knot before; 0 in a kink
  exact: boolean; // whether its state is a landmark, solved as accurately as numbers allow
  factors: Factors; // of the Jacobian, for states nearby
}

type End = "swings" | "snaps" | "lifts" | "inadmissible" | "steep" | "lost";

/** How an arm ends, where, and what to say of it. */
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
  muLock: number; // infinite where the tip lifts off; NaN where the path ends before
  x0End: number; // displacement at the end of the pushed arm
  x0Pulled: number; // the same of the pulled arm, negative
}

/** A path as a table, dense enough to be drawn. */
type Curve = Record<"x0" | "fx" | "fy" | "m" | "energy" | "demand", number[]>;

/** What divides the map of regimes at one taper. */
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
type Limit = "slips" | "swings" | "slips back" | "snaps" | "lifts" | "inadmissible" | "unknown";

/** What the path and the friction say of sticking, all in displacements x0. */
interface Sticking {
  path: Path;
  friction: Friction;
  high: number; // where it ends when x0 grows
  highBy: Limit;
  low: number; // where it ends when x0 falls
  lowBy: Limit;
  touch: number; // where the tip's slope is zero; NaN where it never is
  lock: number; // the critical state; NaN where the tip slips before
}

/** Where clamp and tip are. */
interface Place {
  clamp: number;
  contact: number; // position of the tip along the surface
  side: number; // 1 where the tip is ahead of the clamp, -1 where the rod trails behind it
}

/** What happens on the way of the clamp. */
interface Incident {
  what: Limit | "lies down" | "peels off" | "passes through" | "comes free" | "locks" | "unlocks";
  clamp: number;
  x0: number;
  rest: number; // displacement afterwards
  side: number; // on which the tip is then
}

/** Where a move leads, and what happens on the way. */
interface Move {
  place: Place;
  events: Incident[];
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

type NumberKey = "theta" | "eta" | "mu0" | "dx0" | "ratio" | "modulus" | "diameter" | "length" | MountingKey;
type MountingKey = "beta" | "compliance" | "kappa0" | "kappa1" | "delta";

/** What a user sets: angles in degrees, E in GPa, diameter and length in mm. */
interface Settings extends Record<NumberKey, number> {
  contact: Contact;
  section: "round" | "planar";
  law: SlipLaw;
  units: "none" | "si";
  speed: "slow" | "normal" | "fast";
  labels: "on" | "off";
}

/** The rod of a sensor, which turns units of L and E·I0 into SI units. */
type Whisker = Pick<Settings, "modulus" | "diameter" | "length">;

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
  words: [string, string][]; // the word, and what the page says for it
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

/** All that a link brings back. */
interface Shared {
  settings: Settings;
  clamp: number;
  x0: number; // NaN where the clamp was moved there from the start
  side: number;
  pins: Settings[]; // rods of the pinned curves
}

/** What is known of a place. */
interface Reading extends Place {
  x0: number;
  state: State;
  fx: number;
  fy: number;
  m: number;
  phi1: number;
  sc: number;
  demand: number;
  energy: number;
}

/** A measured recording; a sample that is missing is NaN. */
interface Recording extends Record<"clamp" | "fx" | "fy" | "m", number[]> {
  name: string;
}

type Quantity = "length" | "force" | "moment" | "energy" | "number" | "angle";

interface Units {
  scale: Record<Quantity, number>; // what a nondimensional value is multiplied with
  name: Record<Quantity, string>;
}

/** A rod whose curve stays. */
interface Pin {
  settings: Settings;
  curve: Curve;
}

/** All that the plots show. */
interface View {
  settings: Settings;
  units: Units;
  sticking: Sticking;
  curve: Curve;
  now: Reading;
  trace: Reading[];
  recording: Recording | null;
  divisions: Division[];
  pins: Pin[];
}

/** What is to be seen of the rod. */
interface Scene {
  settings: Settings;
  now: Reading;
  shape: Shape;
  first: Shape; // that at α = 0
  length: number; // what a length is multiplied with, for the ruler
  unit: number; // force that is drawn as long as a quarter of L
  slides: boolean; // whether the tip slips
}
