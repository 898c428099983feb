// Distances of all pairs as they were computed at frames; between two, those of the earlier count.
import { countBelow } from "gcodesim/data";

const EDGE_MM = 1e-6; // a finding's time is when the clearance is reached, give or take this

export class Distances {
  /** Fill a list with a row per pair, the nearest first; a row is an event: its nearest frame. */
  constructor(list, data) {
    Object.assign(this, data.distances);
    this.rows = this.pairs.map((pair, number) => this.makeRow(pair, number))
      .filter((row) => row.frame !== undefined)
      .sort((a, b) => this.at(a.frame, a.number) - this.at(b.frame, b.number));
    list.append(...this.rows.map(({ row }) => row));
  }

  /** Distance of a pair at a frame [mm]; NaN where one of the two is not there. */
  at(frame, number) {
    return this.distance[frame * this.pairs.length + number];
  }

  makeRow(pair, number) {
    const frame = this.nearestFrame(number), time = this.time[frame];
    const made = { pair, number, frame, time, point: this.middle(frame, pair) };
    for (const [key, tag] of [["row", "li"], ["name", "span"], ["value", "b"]]) {
      made[key] = document.createElement(tag);
    }
    made.name.textContent = pair.join(" - ");
    made.row.title = `nearest of all frames: ${text(this.at(frame, number))} at ${time?.toFixed(3)} s`;
    made.row.append(made.name, made.value);
    return made;
  }

  /** Frame at which a pair is nearest; undefined where it never is there. */
  nearestFrame(number) {
    let best, least = Infinity;
    this.time.forEach((_, frame) => {
      if (this.at(frame, number) < least) [best, least] = [frame, this.at(frame, number)];
    });
    return best;
  }

  /** The last frame that is not after a time; -1: there is none. */
  frameAt(time) {
    const next = countBelow(this.time, time);
    return this.time[next] === time ? next : next - 1;
  }

  /** Tell the distances of a frame: the smallest marked, and what touches or is nearer than it may. */
  show(frame) {
    const smallest = Math.min(...this.rows.map((row) => this.at(frame, row.number)).filter((mm) => mm >= 0));
    for (const { row, number, value } of this.rows) {
      value.textContent = text(this.at(frame, number));
      const distance = this.at(frame, number);
      row.classList.toggle("smallest", distance === smallest);
      row.classList.toggle("alarm", distance <= this.clearance[number] + EDGE_MM);
    }
  }

  /** Halfway between the nearest points of a pair at a frame. */
  middle(frame, pair) {
    const points = this.pointsAt(frame, pair);
    return points && [0, 1, 2].map((axis) => (points[axis] + points[axis + 3]) / 2);
  }

  /** Nearest points at a frame, six numbers: of a pair where they are known, else of the nearest. */
  pointsAt(frame, pair) {
    let chosen, least = Infinity;
    for (let row = 0; row < this.link.length / 2; row++) {
      const [at, number] = this.link.subarray(2 * row, 2 * row + 2);
      const distance = String(this.pairs[number]) === String(pair) ? -1 : this.at(at, number);
      if (at === frame && distance < least) [chosen, least] = [row, distance];
    }
    return chosen === undefined ? undefined : this.points.subarray(6 * chosen, 6 * chosen + 6);
  }
}

/** A distance as people read it. */
function text(distance) {
  if (!(distance >= 0)) return "not known";
  return distance === 0 ? "touches" : `${distance.toFixed(3)} mm`;
}
