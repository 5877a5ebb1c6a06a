// Requests to the gateway, and their responses.
import type { Fault } from "./i18n";
import { jsonIn } from "./json";

export interface Refusal extends Fault {
  status: number; // 0: no response
  error: string;
  what: string;
  evidence?: Record<string, unknown> | undefined;
  body?: unknown;
  /** The request changes something: without a response, it is not known whether it was executed. */
  writes?: boolean;
}

export type Answer<T> = { ok: true; value: T; status: number } | { ok: false; refusal: Refusal };

/** Called for every response, of any status: the gateway is available. */
export const onHeard: { call: () => void } = { call: () => undefined };
export const onTokenNeeded: { call: () => void } = { call: () => undefined };

export interface Options {
  method?: string;
  body?: unknown; // JSON, or a Blob, which is sent unchanged
  timeout?: number; // milliseconds; 0: none
  accept?: string;
}

export function refusalOf(status: number, body: unknown): Refusal {
  const json = typeof body === "object" && body !== null ? (body as Record<string, unknown>) : {};
  const { error_id, error_args, error_remarks } = json as Fault;
  return {
    ...(error_id !== undefined && { error_id, error_args: error_args ?? {}, error_remarks: error_remarks ?? [] }),
    status,
    error: typeof json.error === "string" ? json.error : `HTTP ${status}`,
    what: typeof json.what === "string" ? json.what : "",
    evidence: typeof json.evidence === "object" && json.evidence !== null ? (json.evidence as Record<string, unknown>) : undefined,
    body,
  };
}

export const isWrite = ({ method = "GET" }: Options): boolean => method !== "GET";

/** The path of the page without its file: a reverse proxy may serve it below a path. */
const base = (): string => location.pathname.replace(/[^/]*$/, "");
export const path = (route: string): string => base() + route.replace(/^\//, "");

export function requestOf({ method = "GET", body, accept = "application/json" }: Options): RequestInit {
  const isFile = body instanceof Blob;
  const type: Record<string, string> = body === undefined ? {} : { "Content-Type": isFile ? "application/octet-stream" : "application/json" };
  const init: RequestInit = { method, cache: "no-store", credentials: "same-origin", headers: { Accept: accept, ...type } };
  if (body !== undefined) init.body = isFile ? body : JSON.stringify(body);
  return init;
}

export async function ask<T>(route: string, options: Options = {}): Promise<Answer<T>> {
  const abort = new AbortController();
  const timer = options.timeout ? setTimeout(() => abort.abort(), options.timeout) : undefined;
  try {
    const response = await fetch(path(route), { ...requestOf(options), signal: abort.signal });
    onHeard.call();
    const json = jsonIn(await response.text());
    if (response.status === 401 && route !== "/login") onTokenNeeded.call();
    if (!response.ok) return { ok: false, refusal: refusalOf(response.status, json) };
    return { ok: true, value: json as T, status: response.status };
  } catch {
    return { ok: false, refusal: { status: 0, error: "", what: "no_contact", writes: isWrite(options) } };
  } finally {
    clearTimeout(timer);
  }
}

export function socketAddress(route: string): string {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${location.host}${path(route)}`;
}
