// Signs in with a link of “anoctl web --qr”. Its one-time code is after the #, and therefore in no request, log or Referer.
import { logIn } from "./gateway";
import { Store } from "./store";

/** Accepts no six-digit codes: another site could open the page with guessed digits. */
export const linkCodeOf = (hash: string): string | undefined => /^#once=([0-9a-f]{32})$/.exec(hash)?.[1];

/** The link was already used, or has expired. */
export const linkIsOver = new Store(false);

/** Waits for prerendering to end: a browser may load a page before its user opens it. */
const shown = (): Promise<void> =>
  new Promise((done) => {
    if ((document as { prerendering?: boolean }).prerendering) document.addEventListener("prerenderingchange", () => done(), { once: true });
    else done();
  });

async function signIn(): Promise<void> {
  const hash = location.hash, code = linkCodeOf(hash);
  if (hash.startsWith("#once=")) history.replaceState(null, "", "#/");
  if (code === undefined) return;
  await shown();
  const refusal = await logIn(code, "code");
  linkIsOver.set(refusal?.status === 401);
}

/** To be called before the hash is read as a page. */
export async function beginSignIn(): Promise<void> {
  addEventListener("hashchange", () => void signIn());
  await signIn();
}
