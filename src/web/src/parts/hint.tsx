// A text with options of a command line, which are not split over two lines.

const options = /(--[a-z-]+(?: [\w.:]+=[\p{L}\w]+)?|\b[a-z_]+=[\p{L}\w]+)/u;

export function Hint({ text }: { text: string }) {
  return <>{text.split(options).map((part, i) => (i % 2 === 1 ? <code key={i} class="whole">{part}</code> : part))}</>;
}
