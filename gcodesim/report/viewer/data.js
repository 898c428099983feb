// The data of the page: numbers unpacked, and the joints and the line at any time.

/** Bytes that Python's zlib packed, as base64. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Number of entries of an ascending array that are below a value. */
export function countBelow(sorted, value) {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Read the page's JSON and unpack its columns. */
export async function readData() {
  const data = JSON.parse(document.getElementById("data").textContent);
  for (const mesh of data.meshes) {
    mesh.vertices = new Float32Array(await unpacked(mesh.vertices));
    mesh.faces = new Uint32Array(await unpacked(mesh.faces));
  }
  for (const name of ["time", "positions"]) {
    data.knots[name] = new Float64Array(await unpacked(data.knots[name]));
  }
  const { distances } = data;
  for (const name of ["time", "distance"]) {
    distances[name] = new Float64Array(await unpacked(distances[name]));
  }
  distances.link = new Int32Array(await unpacked(distances.link));
  distances.points = new Float32Array(await unpacked(distances.points));
  if (data.program) {
    data.program.time = new Float64Array(await unpacked(data.program.time));
    data.program.line = new Int32Array(await unpacked(data.program.line));
    data.program.text = new TextDecoder().decode(await unpacked(data.program.text)).split("\n");
  }
  data.duration = data.knots.time[data.knots.time.length - 1];
  return data;
}

/** Joint positions at a time, straight between the knots. */
export function positionsAt(data, time) {
  const { time: times, positions } = data.knots;
  const count = data.joints.length;
  const next = Math.min(Math.max(countBelow(times, time), 1), times.length - 1);
  if (times.length === 1) return Array.from(positions.subarray(0, count));
  const span = times[next] - times[next - 1];
  const share = Math.min(Math.max((time - times[next - 1]) / span, 0), 1);
  return Array.from({ length: count }, (_, joint) => {
    const from = positions[(next - 1) * count + joint];
    return from + share * (positions[next * count + joint] - from);
  });
}

/** Line in force at a time, counted through all texts from 1; a boundary belongs to what ends. */
export function lineAt(data, time) {
  if (!data.program || !data.program.line.length) return 0;
  return data.program.line[Math.max(countBelow(data.program.time, time) - 1, 0)];
}

/** Just after the block of a line, or else of the next one, begins; undefined after the last. */
export function timeOfLine(data, line) {
  const { time, line: lines } = data.program;
  let best = -1;
  for (let row = 0; row < lines.length; row++) {
    if (lines[row] >= line && (best < 0 || lines[row] < lines[best])) best = row;
  }
  return best < 0 ? undefined : time[best] + 1e-9;
}
