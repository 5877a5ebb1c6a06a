// Signing in by a link of “anoctl web --qr”. Its one-time code is behind the #, and so in no request, log or Referer.
import { logIn } from "./gateway";
import { Store } from "./store";

/** Not the six digits: another site could open the page with digits that it guesses. */
export const linkCodeOf = (hash: string): string | undefined => /^#once=([0-9a-f]{32})$/.exec(hash)?.[1];

/** A link was used, or has expired. */
export const linkIsOver = new Store(false);

/** A browser may load a page before its user wants it. */
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

/** Before the address is read as that of a page. */
export async function beginSignIn(): Promise<void> {
  addEventListener("hashchange", () => void signIn());
  await signIn();
}
