// SPDX-License-Identifier: MIT

import assert from "node:assert/strict";
import test from "node:test";
import { texts } from "../../src/texts/texts.js";
import { WebSocketPort } from "../../src/port/web_socket.js";

class FakeSocket {
    constructor(url, protocols) {
        if (!url.startsWith("ws")) throw new SyntaxError("not an address");
        FakeSocket.last = this;
        this.url = url;
        this.protocols = protocols;
        this.sent = [];
    }

    send(bytes) {
        this.sent.push([...bytes]);
    }

    close() {
        this.isClosed = true;
    }
}

async function opened() {
    const port = new WebSocketPort("ws://x/websockify", { Socket: FakeSocket });
    const open = port.open();

    FakeSocket.last.onopen();
    await open;
    return { port, socket: FakeSocket.last };
}

const codeOf = (promise) => promise.then(() => "ok", (error) => error.code);

test("web socket: a text frame has no bytes", async () => {
    const { port, socket } = await opened();
    const heard = [];

    port.onBytes = (bytes) => heard.push(bytes);
    for (const data of ["99999999999999", "5"]) socket.onmessage({ data });
    assert.deepEqual(heard, []);
});

test("web socket: binary, both directions", async () => {
    const { port, socket } = await opened();
    let bytes;

    port.onBytes = (some) => (bytes = some);
    port.write(Uint8Array.of(1, 2));
    socket.onmessage({ data: Uint8Array.of(3, 4).buffer });
    assert.deepEqual(socket.protocols, ["binary"]);
    assert.equal(socket.binaryType, "arraybuffer");
    assert.deepEqual(socket.sent, [[1, 2]]);
    assert.deepEqual(bytes, Uint8Array.of(3, 4));
});

test("web socket: refused", async () => {
    const port = new WebSocketPort("ws://x", { Socket: FakeSocket });
    const open = codeOf(port.open());

    FakeSocket.last.onerror();
    assert.equal(await open, "nothing-there");
    assert.ok(FakeSocket.last.isClosed);
});

test("web socket: no notice has the code of another one", () => {
    const codes = [texts.port, texts.wire, texts.notice].flatMap(Object.keys);

    assert.deepEqual(codes.filter((code, index) => codes.indexOf(code) !== index), []);
});

test("web socket: no address", async () => {
    assert.equal(await codeOf(new WebSocketPort("http:/x", { Socket: FakeSocket }).open()), "bad-address");
});

test("web socket: closed by the other end", async () => {
    const { port, socket } = await opened();
    let why;

    port.onClose = (reason) => (why = reason);
    socket.onclose({ code: 1006, reason: "" });
    assert.equal(why, "closed by the other end");
    assert.throws(() => port.write(Uint8Array.of(1)));
});

test("web socket: close is no loss", async () => {
    const { port, socket } = await opened();

    port.onClose = () => assert.fail("lost");
    await port.close();
    assert.ok(socket.isClosed);
    assert.equal(socket.onclose, null);
});

test("web socket: close ends the opening", async () => {
    const port = new WebSocketPort("ws://x", { Socket: FakeSocket });
    const open = codeOf(port.open());

    await port.close();
    assert.ok(FakeSocket.last.isClosed);
    assert.equal(await open, "nothing-there");
});

test("web socket: the address beside a page", () => {
    assert.equal(WebSocketPort.urlBeside({ protocol: "http:", host: "127.0.0.1:8055" }), "ws://127.0.0.1:8055/websockify");
    assert.equal(WebSocketPort.urlBeside({ protocol: "https:", host: "a.b" }), "wss://a.b/websockify");
    assert.equal(WebSocketPort.urlBeside({ protocol: "file:", host: "" }), null);
});
