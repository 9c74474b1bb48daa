// Systems of linear equations: LU factors with partial pivoting.

/** Factorise a matrix, given row by row and overwritten. @type {(matrix: Float64Array, size: number) => Factors} */
export function factorised(matrix, size) {
  const order = new Int32Array(size).map((_, i) => i);
  let sign = 1;
  for (let k = 0; k < size; k += 1) {
    sign *= pivoted(matrix, order, size, k);
    const inverse = 1 / matrix[k * size + k];
    for (let i = k + 1; i < size; i += 1) {
      const factor = matrix[i * size + k] * inverse;
      matrix[i * size + k] = factor;
      if (factor === 0) continue;
      const to = i * size;
      const from = k * size;
      for (let j = k + 1; j < size; j += 1) matrix[to + j] -= factor * matrix[from + j];
    }
  }
  return { size, rows: matrix, order, sign };
}

/**
 * Move the row with the largest entry of a column to the diagonal; returns -1 if two rows were exchanged, else 1.
 * @type {(matrix: Float64Array, order: Int32Array, size: number, k: number) => number}
 */
function pivoted(matrix, order, size, k) {
  let pivot = k;
  for (let i = k + 1; i < size; i += 1) {
    if (Math.abs(matrix[i * size + k]) > Math.abs(matrix[pivot * size + k])) pivot = i;
  }
  if (pivot === k) return 1;
  [order[k], order[pivot]] = [order[pivot], order[k]];
  for (let j = 0; j < size; j += 1) {
    const kept = matrix[k * size + j];
    matrix[k * size + j] = matrix[pivot * size + j];
    matrix[pivot * size + j] = kept;
  }
  return -1;
}

/**
 * Solve a system with a factorised matrix; the solution is not finite if the matrix is singular.
 * @type {(factors: Factors, right: Float64Array) => Float64Array}
 */
export function solved({ size, rows, order }, right) {
  const x = new Float64Array(size);
  for (let i = 0; i < size; i += 1) {
    let sum = right[order[i]];
    for (let j = 0; j < i; j += 1) sum -= rows[i * size + j] * x[j];
    x[i] = sum;
  }
  for (let i = size - 1; i >= 0; i -= 1) {
    let sum = x[i];
    for (let j = i + 1; j < size; j += 1) sum -= rows[i * size + j] * x[j];
    x[i] = sum / rows[i * size + i];
  }
  return x;
}

/** @type {(factors: Factors) => number} */
export function determinant({ size, rows, sign }) {
  let value = sign;
  for (let k = 0; k < size; k += 1) value *= rows[k * size + k];
  return value;
}

/**
 * Whether a symmetric matrix, given row by row and overwritten, is positive definite.
 * @type {(matrix: Float64Array, size: number) => boolean}
 */
export function isPositive(matrix, size) {
  for (let k = 0; k < size; k += 1) {
    const pivot = matrix[k * size + k];
    if (!(pivot > 0)) return false;
    for (let i = k + 1; i < size; i += 1) {
      const factor = matrix[i * size + k] / pivot;
      for (let j = k + 1; j < size; j += 1) matrix[i * size + j] -= factor * matrix[k * size + j];
    }
  }
  return true;
}

/**
 * Product of a row-by-row matrix and a vector.
 * @type {(matrix: Float64Array, vector: Float64Array) => Float64Array}
 */
export function product(matrix, vector) {
  const count = vector.length;
  const result = new Float64Array(matrix.length / count);
  for (let i = 0; i < result.length; i += 1) {
    let sum = 0;
    for (let k = 0; k < count; k += 1) sum += matrix[i * count + k] * vector[k];
    result[i] = sum;
  }
  return result;
}
