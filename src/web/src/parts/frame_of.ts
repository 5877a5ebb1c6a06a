// Makes the JSON of a frame from the values typed in the form. Pure.
import { isNumber, isNumeric, type FieldRow, type MessageRow } from "../protocol/table";
import { isWide, numberIn } from "./numbers";

export type Typed = { frame: { from: number; to: number; name: string; fields: Record<string, unknown> } } | { fault: string };

function valueOf(field: FieldRow, text: string): unknown {
  if (!isNumeric(field.type)) return field.type === "bytes" ? text.replace(/\s+/g, "").toLowerCase() : text;
  const numbers = isNumber(field) ? [numberIn(text)] : text.split(/[\s,]+/).filter(Boolean).map(numberIn);
  if (numbers.some((n) => n === undefined)) return undefined;
  if (!isNumber(field)) return numbers;
  return isWide(field.type) && !Number.isSafeInteger(numbers[0]) ? text.trim() : numbers[0];
}

/** Empty fields are omitted, except those that select this layout. */
export function frameOf(row: MessageRow, from: string, to: string, values: Record<string, string>): Typed {
  const source = numberIn(from), destination = numberIn(to);
  if (source === undefined) return { fault: "from" };
  if (destination === undefined) return { fault: "to" };
  const fields: Record<string, unknown> = {};
  for (const field of row.fields) {
    const text = values[field.name] ?? "";
    if (text.trim() === "") {
      if (field.only) fields[field.name] = field.only[0];
      else if (row.layout !== undefined && isNumber(field)) fields[field.name] = 0;
      continue;
    }
    const value = valueOf(field, text);
    if (value === undefined) return { fault: field.label ?? field.name };
    fields[field.name] = value;
  }
  return { frame: { from: source, to: destination, name: row.name, fields } };
}
