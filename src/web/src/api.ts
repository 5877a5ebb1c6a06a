// Questions to the gateway, and how they ended.

export interface Refusal {
  status: number; // 0: there was no answer
  error: string;
  what: string;
  evidence?: Record<string, unknown> | undefined;
  body?: unknown;
}

export type Answer<T> = { ok: true; value: T; status: number } | { ok: false; refusal: Refusal };

/** Told of every answer, whatever it says: the gateway is there. */
export const onHeard: { call: () => void } = { call: () => undefined };
export const onTokenNeeded: { call: () => void } = { call: () => undefined };

interface Options {
  method?: string;
  body?: unknown; // JSON, or a Blob as it is
  timeout?: number; // milliseconds; 0: none
  signal?: AbortSignal;
}

function refusalOf(status: number, body: unknown): Refusal {
  const json = typeof body === "object" && body !== null ? (body as Record<string, unknown>) : {};
  return {
    status,
    error: typeof json.error === "string" ? json.error : `HTTP ${status}`,
    what: typeof json.what === "string" ? json.what : "",
    evidence: typeof json.evidence === "object" && json.evidence !== null ? (json.evidence as Record<string, unknown>) : undefined,
    body,
  };
}

/** Where the page is, without its file: it may stand behind a proxy's path. */
const base = (): string => location.pathname.replace(/[^/]*$/, "");

export async function ask<T>(path: string, options: Options = {}): Promise<Answer<T>> {
  const { method = "GET", body, timeout = 0 } = options;
  const abort = new AbortController();
  const timer = timeout > 0 ? setTimeout(() => abort.abort(), timeout) : undefined;
  options.signal?.addEventListener("abort", () => abort.abort());
  try {
    const init: RequestInit = { method, signal: abort.signal, cache: "no-store", credentials: "same-origin", headers: { Accept: "application/json" } };
    if (body instanceof Blob) {
      init.body = body;
      init.headers = { Accept: "application/json", "Content-Type": "application/octet-stream" };
    } else if (body !== undefined) {
      init.body = JSON.stringify(body);
      init.headers = { Accept: "application/json", "Content-Type": "application/json" };
    }
    const response = await fetch(base() + path.replace(/^\//, ""), init);
    onHeard.call();
    const text = await response.text();
    let json: unknown;
    try {
      json = JSON.parse(text);
    } catch {
      json = undefined;
    }
    if (response.status === 401 && path !== "/login") onTokenNeeded.call();
    if (!response.ok) return { ok: false, refusal: refusalOf(response.status, json) };
    return { ok: true, value: json as T, status: response.status };
  } catch {
    return { ok: false, refusal: { status: 0, error: "", what: "no_contact" } };
  } finally {
    clearTimeout(timer);
  }
}

export function socketAddress(path: string): string {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${location.host}${base()}${path.replace(/^\//, "")}`;
}
