/** The page that `chatter explore` opens. */

import { explore, in_address } from "./explorer.js";
import { over_http } from "./asking/transport.js";

const root = /** @type {HTMLElement} */ (document.getElementById("explorer"));
explore(root, over_http, in_address()).catch((error) => {
    root.textContent = `The explorer cannot begin: ${error instanceof Error ? error.message : error}`;
});
