// The program's text: only the rows in sight exist, so that a million lines scroll.
import { timeOfLine } from "gcodesim/data";

const ROW = 18; // height of a row [pixels], as in the style

export class Program {
  /** `jump` is called with the time of a row that was clicked. */
  constructor(panel, data, found, jump) {
    this.panel = panel;
    this.rows = panel.querySelector("#rows");
    this.lines = data.program ? data.program.text : [];
    this.files = data.program ? data.program.files : [];
    this.found = found;
    this.current = 0;
    panel.querySelector("#spacer").style.height = `${this.lines.length * ROW}px`;
    panel.addEventListener("scroll", () => this.fill());
    new ResizeObserver(() => this.fill()).observe(panel);
    this.rows.addEventListener("click", (event) => {
      const row = Math.floor((event.clientY - this.rows.getBoundingClientRect().top) / ROW);
      const time = timeOfLine(data, this.first + row + 1);
      if (time !== undefined) jump(time);
    });
    this.fill();
  }

  /** Name of the file a line stands in, and its number there. */
  place(line) {
    const file = [...this.files].reverse().find(([, before]) => before < Math.max(line, 1));
    return file ? [file[0], line - file[1]] : ["", line];
  }

  /** Mark the line in force and keep it in sight. */
  follow(line) {
    if (line === this.current) return;
    this.current = line;
    const top = (line - 1) * ROW, height = this.panel.clientHeight;
    if (line && (top < this.panel.scrollTop || top > this.panel.scrollTop + height - 2 * ROW)) {
      this.panel.scrollTop = Math.max(top - height / 3, 0);
    }
    this.fill();
  }

  /** Give the rows in sight their text; rows are kept, so that a click meets the one it began on. */
  fill() {
    this.first = Math.max(Math.floor(this.panel.scrollTop / ROW) - 5, 0);
    const wanted = Math.ceil(this.panel.clientHeight / ROW) + 10;
    const count = Math.max(Math.min(wanted, this.lines.length - this.first), 0);
    while (this.rows.children.length > count) this.rows.lastChild.remove();
    while (this.rows.children.length < count) this.rows.append(document.createElement("div"));
    this.rows.style.top = `${this.first * ROW}px`;
    Array.from(this.rows.children).forEach((row, index) => {
      const line = this.first + index + 1;
      const [file, number] = this.place(line);
      row.textContent = this.lines[line - 1] || " ";
      row.dataset.line = line;
      row.dataset.number = number;
      row.title = `${row.textContent.trim()}\n${file}`; // long lines are cut where they are not scrolled
      row.classList.toggle("current", line === this.current);
      row.classList.toggle("found", this.found.has(line));
    });
  }
}
