// Characters that control how other characters are displayed, or that are invisible.
const hidden = /[\u0000-\u0008\u000b-\u001f\u007f-\u009f\u00ad\u034f\u061c\u115f\u1160\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\u2800\u3164\ufeff\uffa0\ufff9-\ufffb]/g;

/** Replaces them by U+FFFD. Tabs and line ends are kept. */
export const visible = (text: string): string => text.replace(hidden, "\ufffd");

/** For text where no <bdi> element is possible, such as an option. */
export const isolated = (text: string): string => (text === "" ? "" : `\u2068${visible(text)}\u2069`);
