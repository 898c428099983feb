// The page: what every button does, and the clock.
import { lineAt, positionsAt, readData } from "gcodesim/data";
import { Distances } from "gcodesim/distances";
import { Program } from "gcodesim/program";
import { Scene } from "gcodesim/scene";

const AXES = "XYZABCUVW"; // the order in which a control shows them
const STATES = ["shown", "ghost", "hidden"];
const CAMERAS = { whole: undefined, front: [0, -1, 0.05], side: [1, 0, 0.05], top: [0, -0.01, 1] };
const byId = (id) => document.getElementById(id);

/** An element with text and classes; text is never read as markup. */
function element(tag, text = "", ...classes) {
  const made = document.createElement(tag);
  made.textContent = text;
  made.classList.add(...classes);
  return made;
}

class Viewer {
  constructor(data) {
    this.data = data;
    this.report = data.report;
    this.time = 0;
    this.playing = false;
    this.events = [...this.report.findings, ...(this.report.suppressed ?? [])]
      .map((finding) => this.event(finding));
    const found = new Set(this.events.filter((e) => e.finding.severity !== "note").map((e) => e.line));
    this.scene = new Scene(byId("view"), data);
    this.program = new Program(byId("program"), data, found, (time) => this.setTime(time));
    this.fillHeading();
    this.fillFindings();
    this.fillDistances();
    this.distances = new Distances(byId("now"), data);
    this.distances.rows.forEach((row) => this.makeTimed(row));
    byId("now-section").hidden = !this.distances.rows.length;
    this.fillBodies();
    this.fillGaps();
    this.listen();
    this.setTime(0);
    this.scene.lookAtAll();
    const first = this.report.first_contact;
    const event = this.events.find((e) => first && e.time === first.time_s);
    if (event) this.select(event);
    requestAnimationFrame((now) => this.tick(now));
  }

  /** A finding with its time, its line through all texts, and the point where bodies touch. */
  event(finding) {
    const { first_contact: first } = this.report;
    const file = (this.data.program?.files ?? []).find(([name]) => name === finding.file);
    const isFirst = first && finding.time_s === first.time_s
      && String(finding.pair) === String(first.pair);
    return {
      finding,
      time: finding.time_s,
      line: finding.line && file ? finding.line + file[1] : 0,
      pair: finding.pair,
      point: isFirst ? first.point_mm : undefined,
    };
  }

  fillHeading() {
    byId("verdict").textContent = this.report.verdict;
    byId("verdict").className = this.report.verdict;
    byId("heading").textContent = `${this.report.program} on ${this.report.machine}`
      + (this.report.verified_model ? "" : " (unverified model)");
    byId("contract").textContent = this.data.contract;
    byId("note").textContent = this.data.note;
  }

  fillFindings() {
    const order = ["error", "warning", "note"];
    const sorted = [...this.events].sort(
      (a, b) => order.indexOf(a.finding.severity) - order.indexOf(b.finding.severity));
    for (const event of sorted) {
      const { code, message, severity, line, ignored } = event.finding;
      const when = event.time === undefined ? "" : ` (${event.time.toFixed(3)} s)`;
      const text = `${ignored ? "ignored: " : ""}${code} ${line ? `line ${line}: ` : ""}${message}${when}`;
      event.row = element("li", text, "finding", severity);
      byId("findings").append(event.row);
      if (event.time === undefined) continue;
      this.makeTimed(event);
      const mark = element("b", "", severity);
      mark.style.left = `${(100 * event.time) / (this.data.duration || 1)}%`;
      mark.title = text;
      mark.addEventListener("click", () => this.select(event));
      byId("marks").append(mark);
    }
    if (!this.events.length) byId("findings").append(element("li", "nothing was found"));
  }

  /** The smallest distances are known where contacts were followed or smallest distances asked for. */
  fillDistances() {
    const rows = [
      ...this.report.contacts.map((c) => [c.pair, -c.deepest_mm, c.deepest_at_s, "deepest"]),
      ...this.report.clearances.map((c) => [c.pair, c.minimum_mm, c.time_s, "nearest"]),
    ].sort((a, b) => a[1] - b[1]);
    byId("distances-section").hidden = !rows.length;
    for (const [pair, distance, time, kind] of rows) {
      const text = `${pair.join(" - ")}: ${distance.toFixed(3)} mm (${kind}, ${time.toFixed(3)} s)`;
      const event = { time, pair, row: element("li", text) };
      byId("distances").append(event.row);
      this.makeTimed(event);
    }
  }

  makeTimed(event) {
    event.row.classList.add("timed");
    event.row.tabIndex = 0;
    event.row.addEventListener("click", () => this.select(event));
    event.row.addEventListener("keydown", (key) => { if (key.key === "Enter") this.select(event); });
  }

  fillBodies() {
    this.data.bodies.forEach((body, number) => {
      const row = element("li");
      const button = element("button", STATES[0]);
      button.dataset.body = body.name;
      button.addEventListener("click", () => {
        this.setState(number, STATES[(STATES.indexOf(button.textContent) + 1) % STATES.length]);
      });
      row.append(element("span", [body.name, body.title].filter(Boolean).join(" ")), button);
      byId("bodies").append(row);
    });
  }

  setState(number, state) {
    byId("bodies").querySelectorAll("button")[number].textContent = state;
    this.scene.setState(number, state);
    this.setTime(this.time);
  }

  /** Ghost all bodies but those of the selected finding. */
  focus() {
    this.data.bodies.forEach((body, number) => {
      this.setState(number, this.selected?.pair?.includes(body.name) ? "shown" : "ghost");
    });
  }

  fillGaps() {
    const { coverage } = this.report;
    const gaps = ["unsupported", "ignored", "uncertified", "unchecked_by_rule", "off_path"]
      .flatMap((key) => coverage[key].map((text) => `${key.replaceAll("_", " ")}: ${text}`));
    if (!coverage.between_samples) gaps.unshift("the time between samples");
    byId("gaps").append(...(gaps.length ? gaps : ["nothing"]).map((text) => element("li", text)));
  }

  listen() {
    byId("time").addEventListener("input", () => this.setTime(byId("time").value * this.data.duration));
    byId("play").addEventListener("click", () => this.setPlaying(!this.playing));
    byId("frame").addEventListener("click", () => this.setTime(this.distances.time[this.frame]));
    byId("focus").addEventListener("click", () => this.focus());
    for (const button of document.querySelectorAll("[data-camera]")) {
      button.addEventListener("click", () => this.aim(button.dataset.camera));
    }
    document.addEventListener("keydown", (event) => {
      if (event.code === "Space" && !["BUTTON", "SELECT"].includes(event.target.tagName)) {
        event.preventDefault();
        this.setPlaying(!this.playing);
      }
    });
  }

  aim(camera) {
    if (camera !== "near") this.scene.lookAtAll(CAMERAS[camera]);
    else if (this.selected?.pair) this.scene.lookNear(this.selected.point, this.selected.pair);
  }

  /** Go to the time of a finding or distance; its two bodies are coloured until another is chosen. */
  select(event) {
    this.selected?.row.classList.remove("selected");
    this.selected = event;
    event.row.classList.add("selected");
    this.setPlaying(false);
    this.setTime(event.time);
    this.scene.highlight(event.pair);
  }

  setPlaying(playing) {
    if (playing && this.time >= this.data.duration) this.setTime(0);
    this.playing = playing;
    byId("play").textContent = playing ? "pause" : "play";
  }

  setTime(time) {
    const { data } = this;
    this.time = Math.min(Math.max(time, 0), data.duration);
    this.positions = positionsAt(data, this.time);
    this.scene.pose(this.positions, this.time);
    this.scene.setMark(this.selected?.time === this.time ? this.selected.point : undefined);
    this.showDistances();
    this.program.follow(lineAt(data, this.time));
    byId("time").value = data.duration ? this.time / data.duration : 0;
    byId("clock").textContent = `${this.time.toFixed(3)} / ${data.duration.toFixed(3)} s`;
    byId("axes").textContent = data.joints
      .map((joint, number) => `${joint.name} ${this.positions[number].toFixed(3)}`)
      .sort((a, b) => AXES.indexOf(a[0]) - AXES.indexOf(b[0])).join("  ");
  }

  /** Tell the distances; the line between the nearest points stands only where they were computed. */
  showDistances() {
    const { distances, time } = this;
    const frame = distances.frameAt(time);
    if (frame !== this.frame && frame >= 0) {
      this.frame = frame;
      distances.show(frame);
      byId("frame").textContent = `at ${distances.time[frame].toFixed(3)} s`;
    }
    const there = frame >= 0 && distances.time[frame] === time;
    this.scene.setLine(there ? distances.pointsAt(frame, this.selected?.pair) : undefined);
  }

  tick(now) {
    if (this.playing) {
      const passed = (now - this.last) / 1000;
      this.setTime(this.time + passed * Number(byId("speed").value));
      if (this.time >= this.data.duration) this.setPlaying(false);
    }
    this.last = now;
    this.scene.draw();
    requestAnimationFrame((next) => this.tick(next));
  }
}

window.viewer = new Viewer(await readData());
document.body.dataset.ready = "yes";
