// SPDX-License-Identifier: MIT
/* Connection of the page: found servos, a port that goes away, a second page, a foreign page. */

import assert from "node:assert/strict";
import { createServer, get } from "node:http";
import test from "node:test";
import { openPage, shows, startBrowser, startPanel, startRobot } from "../support/browser.js";

test("page finds the servos and shows their feedback", async (t) => {
    const { page } = await startRobot(t, { count: 18 });

    await shows(page, /\d\d+ updates a second/, ".state-line");
    await shows(page, "Servo 18");
});

test("page tells that the simulator has gone, and connects again", async (t) => {
    const { panel, page } = await startRobot(t);

    await panel.end();
    await shows(page, "The port was lost");
    await shows(page, "Not connected", ".state-line");
    await startPanel(t, { port: panel.port });
    await page.click("button.socket");
    await shows(page, /Connected .* 3 servos/, ".state-line");
});

test("second page is told that the first one has the port", async (t) => {
    const { panel, browser, page } = await startRobot(t);
    const second = await openPage(t, browser, panel.url);

    await shows(second, "Another page or program is connected");
    await page.bringToFront();
    await shows(page, /[1-9]\d* updates a second/, ".state-line");
});

test("a page that is left gives the port free, though the browser keeps it", async (t) => {
    const { panel, browser, page } = await startRobot(t);

    await page.goto(`${panel.url}#board`); // the same page
    await page.goto("about:blank");
    const second = await openPage(t, browser, panel.url);

    await shows(second, /Connected .* 3 servos/, ".state-line");
    await page.goBack();
    await page.bringToFront();
    await shows(page, "Not connected", ".state-line");
});

test("a page in a frame does not connect", async (t) => {
    const panel = await startPanel(t);
    const browser = await startBrowser(t);
    const around = createServer((_, reply) => reply.setHeader("Content-Type", "text/html").end(`<iframe src="${panel.url}"></iframe>`));

    t.after(() => around.close());
    await new Promise((resolve) => around.listen(0, "127.0.0.1", resolve));
    const page = await openPage(t, browser, `http://127.0.0.1:${around.address().port}`);
    const frame = await (await page.waitForSelector("iframe")).contentFrame();

    await shows(frame, "does not connect");
    assert.equal(await frame.$("button"), null);
    const second = await openPage(t, browser, panel.url);

    await shows(second, /Connected .* 3 servos/, ".state-line");
});

/* Asks for a WebSocket as a page of `origin` would. Resolves with the status: 101 is a connection. */
function handshake(port, origin) {
    const headers = {
        Origin: origin,
        Connection: "Upgrade",
        Upgrade: "websocket",
        "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Protocol": "binary",
    };

    return new Promise((resolve, reject) => {
        const request = get({ host: "127.0.0.1", port, path: "/websockify", headers }, (reply) => {
            resolve(reply.statusCode);
            request.destroy();
        });

        request.on("upgrade", (reply, socket) => {
            resolve(reply.statusCode);
            socket.destroy();
        });
        request.on("error", reject);
    });
}

test("only a page of this server gets the WebSocket", async (t) => {
    const { port } = await startPanel(t);

    assert.equal(await handshake(port, `http://127.0.0.1:${port}`), 101);
    assert.equal(await handshake(port, "http://127.0.0.1:1"), 403);
    assert.equal(await handshake(port, "https://example.org"), 403);
});
