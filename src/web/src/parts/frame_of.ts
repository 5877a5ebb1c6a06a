// Makes the JSON of a frame from the input in the form of a message. Pure.
import { isNumeric, type FieldRow, type MessageRow } from "../protocol/table";

export type Typed = { frame: { from: number; to: number; name: string; fields: Record<string, unknown> } } | { fault: string };

/** As in C: -1.5, 1e-7, 0xDC; undefined: not a number. */
export function numberIn(text: string): number | undefined {
  const plain = text.trim();
  if (plain === "") return undefined;
  const number = Number(plain);
  return Number.isNaN(number) ? undefined : number;
}

function valueOf(field: FieldRow, text: string): unknown {
  if (!isNumeric(field.type)) return field.type === "bytes" ? text.replace(/\s+/g, "").toLowerCase() : text;
  const words = (field.count ?? 1) === 1 ? [text] : text.split(/[\s,]+/).filter(Boolean);
  const numbers = words.map(numberIn);
  if (numbers.some((n) => n === undefined)) return undefined;
  if ((field.count ?? 1) !== 1) return numbers;
  // Integers that a double can't hold are sent as text.
  return /64$/.test(field.type) && !Number.isSafeInteger(numbers[0]!) && field.type !== "f64" ? text.trim() : numbers[0];
}

/** Empty fields are omitted, except for those that select this layout. */
export function frameOf(row: MessageRow, from: string, to: string, values: Record<string, string>): Typed {
  const source = numberIn(from), destination = numberIn(to);
  if (source === undefined) return { fault: "from" };
  if (destination === undefined) return { fault: "to" };
  const fields: Record<string, unknown> = {};
  for (const field of row.fields) {
    const text = values[field.name] ?? "";
    if (text.trim() === "") {
      if (field.only) fields[field.name] = field.only[0];
      else if (row.layout !== undefined && isNumeric(field.type) && (field.count ?? 1) === 1) fields[field.name] = 0;
      continue;
    }
    const value = valueOf(field, text);
    if (value === undefined) return { fault: field.label ?? field.name };
    fields[field.name] = value;
  }
  return { frame: { from: source, to: destination, name: row.name, fields } };
}
