// Values over time in bounded memory: of old values only the smallest and largest are kept, so that a chart looks the same. Pure.

const capacity = 1 << 17; // points
export const history = 600; // seconds

export class Series {
  private times = new Float64Array(1 << 12);
  private values = new Float64Array(1 << 12);
  private first = 0;
  private end = 0; // index after the last point

  get length(): number {
    return this.end - this.first;
  }

  time(i: number): number {
    return this.times[this.first + i]!;
  }
  value(i: number): number {
    return this.values[this.first + i]!;
  }
  lastTime(): number {
    return this.length > 0 ? this.times[this.end - 1]! : Number.NEGATIVE_INFINITY;
  }

  /** Times must not decrease: an earlier point than the last one is ignored. */
  push(time: number, value: number): void {
    if (time < this.lastTime()) return;
    while (this.first < this.end && this.times[this.first]! < time - history) ++this.first;
    if (this.end === this.times.length) this.makeRoom();
    this.times[this.end] = time;
    this.values[this.end++] = value;
  }

  clear(): void {
    this.first = this.end = 0;
  }

  private makeRoom(): void {
    if (this.first > this.times.length / 4) return this.move(this.times, this.values);
    if (this.times.length >= capacity) return this.thin();
    this.move(new Float64Array(this.times.length * 2), new Float64Array(this.times.length * 2));
  }

  private move(times: Float64Array<ArrayBuffer>, values: Float64Array<ArrayBuffer>): void {
    times.set(this.times.subarray(this.first, this.end));
    values.set(this.values.subarray(this.first, this.end));
    this.end -= this.first;
    this.first = 0;
    this.times = times;
    this.values = values;
  }

  // In the older half, keeps the smallest and the largest of every four points, in order of time.
  private thin(): void {
    this.move(this.times, this.values);
    const { times, values } = this;
    const half = (this.end >> 1) & ~3;
    let to = 0;
    for (let i = 0; i < half; i += 4) {
      let low = i, high = i;
      for (let k = i + 1; k < i + 4; ++k) {
        if (values[k]! < values[low]!) low = k;
        if (values[k]! > values[high]!) high = k;
      }
      const a = Math.min(low, high), b = Math.max(low, high);
      times[to] = times[a]!;
      values[to++] = values[a]!;
      if (b !== a) {
        times[to] = times[b]!;
        values[to++] = values[b]!;
      }
    }
    times.copyWithin(to, half, this.end);
    values.copyWithin(to, half, this.end);
    this.end = to + this.end - half;
  }

  /** The index of the first point at or after `time`. */
  at(time: number): number {
    let low = 0, high = this.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[this.first + middle]! < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The last value at or before `time`; undefined: none within 5 s. */
  before(time: number): number | undefined {
    const i = this.at(time + 1e-9) - 1;
    return i >= 0 && time - this.time(i) < 5 ? this.value(i) : undefined;
  }
}

/** Writes two values for each column of a chart: the smallest and the largest one in it, in order of time; null if it has none. If NaN follows the
 * values, the next column gets NaN, so that the line ends there. */
export function envelope(series: Series, from: number, to: number, columns: number, into: (number | null)[]): void {
  into.length = columns * 2;
  into.fill(null);
  const width = (to - from) / columns;
  let column = -1, low = 0, high = 0, lowAt = 0, highAt = 0;
  const put = (): void => {
    if (column < 0) return;
    into[column * 2] = lowAt <= highAt ? low : high;
    into[column * 2 + 1] = lowAt <= highAt ? high : low;
  };
  const length = series.length;
  for (let i = series.at(from); i < length; ++i) {
    const time = series.time(i), value = series.value(i);
    if (time > to) break;
    const now = Math.max(0, Math.min(columns - 1, Math.floor((time - from) / width)));
    if (Number.isNaN(value)) {
      put();
      column = -1;
      if (now + 1 < columns) into[(now + 1) * 2] = Number.NaN;
    } else if (now !== column) {
      put();
      column = now;
      low = high = value;
      lowAt = highAt = i;
    } else if (value < low) {
      low = value;
      lowAt = i;
    } else if (value > high) {
      high = value;
      highAt = i;
    }
  }
  put();
}

/** Whether an angle wrapped around between two values, for any range (±180°, 0 to 360°): they differ by more than half a turn. */
export const wentOver = (unit: string, a: number, b: number): boolean => unit === "°" && Math.abs(a - b) > 180;

/** The times of the values written by envelope(). */
export function columnTimes(from: number, to: number, columns: number, into: number[]): void {
  into.length = columns * 2;
  const half = (to - from) / (columns * 2);
  for (let i = 0; i < into.length; ++i) into[i] = from + (i + 0.5) * half;
}

const quoted = (text: string): string => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);

/** CSV with one row for each time at which any series has a value. */
export function csvOf(all: readonly { label: string; series: Series }[], from: number, to: number): string {
  const lines = [["time", ...all.map((one) => quoted(one.label))].join(",")];
  const next = all.map((one) => one.series.at(from));
  for (;;) {
    let time = Number.POSITIVE_INFINITY;
    all.forEach((one, k) => {
      if (next[k]! < one.series.length) time = Math.min(time, one.series.time(next[k]!));
    });
    if (time > to) break;
    const cells = all.map((one, k) => {
      const i = next[k]!;
      if (i >= one.series.length || one.series.time(i) !== time) return "";
      next[k] = i + 1;
      return Number.isNaN(one.series.value(i)) ? "" : String(one.series.value(i));
    });
    lines.push([time.toFixed(6), ...cells].join(","));
  }
  return lines.join("\n") + "\n";
}
