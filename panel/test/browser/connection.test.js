// SPDX-License-Identifier: MIT
/* Connection of the page: found servos, a port that goes away, a second page, a foreign page. */

import assert from "node:assert/strict";
import { createServer, get } from "node:http";
import test from "node:test";
import { DESKTOP, PHONE, openPage, prints, shows, startBrowser, startPanel, startRobot } from "../support/browser.js";

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

test("panel.py: Ctrl-C ends it with status 0, also after a collision on the bus", async (t) => {
    const { panel, page } = await startRobot(t, { count: 2 });

    await page.evaluate(() => void document.querySelector("panel-app").session.controller.run("ping 254").catch(() => {})); // both answer
    await prints(panel, /^rule broken .*collision/m);
    assert.equal(await panel.end(), 0);
});

test("panel.py: SIGHUP ends the simulator, too", async (t) => {
    const panel = await startPanel(t);

    assert.equal(await panel.end("SIGHUP"), 0);
});

test("second page is told that the first one has the port", async (t) => {
    const { panel, browser, page } = await startRobot(t);
    const second = await openPage(t, browser, panel.url);

    await shows(second, "Another page or program is connected. Waiting", ".state-line"); // at once
    await shows(second, "Another page or program is connected", ".notice");
    await page.bringToFront();
    await shows(page, /[1-9]\d* updates a second/, ".state-line");
});

test("connection: a page that is left frees the port", async (t) => {
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

test("layout at a width of 200 pixels: no view scrolls sideways", async (t) => {
    const panel = await startPanel(t);
    const page = await openPage(t, await startBrowser(t), panel.url, { viewport: { width: 200, height: 600 } });

    await shows(page, /Connected .* 3 servos/, ".state-line");
    for (const id of await page.$$eval("nav a", (tabs) => tabs.map((tab) => tab.id))) {
        await page.$eval(`#${id}`, (tab) => tab.click());
        await page.waitForSelector(`#${id}[aria-selected=true]`);
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), id);
    }
});

test("only a page of this server gets the WebSocket", async (t) => {
    const { port } = await startPanel(t);

    assert.equal(await handshake(port, `http://127.0.0.1:${port}`), 101);
    assert.equal(await handshake(port, "http://127.0.0.1:1"), 403);
    assert.equal(await handshake(port, "https://example.org"), 403);
});

const ZOOMED = { width: Math.floor(DESKTOP.width / 2), height: DESKTOP.height / 2, deviceScaleFactor: 2 };

/* At the end of the page: the part of the screen that the header covers, and how far Stop is from the top. */
const coveredBy = (page) =>
    page.evaluate(() => {
        scrollTo(0, document.body.scrollHeight);
        const { bottom } = document.querySelector("header").getBoundingClientRect();

        return { part: Math.max(bottom, 0) / innerHeight, stop: document.querySelector("button.stop").getBoundingClientRect().top };
    });

for (const [name, viewport] of Object.entries({ "a desktop at 200 %": ZOOMED, "a phone": PHONE }))
    test(`layout on ${name}: header and notices leave room`, async (t) => {
        const panel = await startPanel(t);
        const page = await openPage(t, await startBrowser(t), panel.url.replace(/[?&]connect/, "") + "#motion", { viewport });

        await page.click("header summary");
        assert.ok((await coveredBy(page)).part < 1 / 3, "while not connected");
        await page.click("button.socket");
        await shows(page, /Connected .* 3 servos/, ".state-line");
        await page.evaluate(() => document.querySelector("panel-app").session.notify({ code: "bad-address", detail: "ws://" + "x".repeat(99) }));
        await page.waitForSelector(".notice");
        const { part, stop } = await coveredBy(page);

        assert.ok(part < 1 / 3 && stop >= 0, `${part} of the screen, Stop at ${stop}`);
        const [text, button] = await page.evaluate(() => {
            const words = document.createRange();

            words.selectNodeContents(document.querySelector(".notice p"));
            return [words.getBoundingClientRect().right, document.querySelector(".notice button").getBoundingClientRect().left];
        });

        assert.ok(text <= button, `text ends at ${text}, the button begins at ${button}`);
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "scrolls sideways");
        await page.click("button.stop");
        await shows(page, "Torque is off", ".stop-state.verified");
        assert.ok((await coveredBy(page)).part < (viewport === PHONE ? 0.21 : 1 / 3), "after Stop");
        await page.evaluate(() => ["back", "silent"].forEach((code) => document.querySelector("panel-app").session.notify({ code })));
        await page.click("button.dismiss-all");
        await page.waitForFunction(() => !document.querySelector(".notice"));
    });
