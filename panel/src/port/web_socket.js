// SPDX-License-Identifier: MIT
/* A WebSocket to the simulator, or to a serial port behind websockify. Interface: web_serial.js. */

import { PortError } from "./web_serial.js";

const OPEN_MS = 5000;

export class WebSocketPort {
    #socket = null;
    #cancel = null; // ends the opening
    #Socket;

    /* `Socket`: WebSocket or a fake of it. */
    constructor(url, { Socket = globalThis.WebSocket } = {}) {
        this.url = url;
        this.name = url;
        this.#Socket = Socket;
        this.onBytes = () => {};
        this.onClose = () => {};
    }

    /* The address of the WebSocket beside the page, or null: the page is no http(s) page. */
    static urlBeside(location) {
        if (!/^https?:$/.test(location.protocol)) return null;
        return `${location.protocol === "https:" ? "wss:" : "ws:"}//${location.host}/websockify`;
    }

    open() {
        let socket;

        try {
            socket = new this.#Socket(this.url, ["binary"]);
        } catch (error) {
            return Promise.reject(new PortError("bad-address", error.message));
        }
        socket.binaryType = "arraybuffer";
        return new Promise((resolve, reject) => this.#await(socket, resolve, reject));
    }

    #await(socket, resolve, reject) {
        const fail = (code) => {
            this.#cancel = null;
            clearTimeout(timer);
            socket.onopen = socket.onclose = socket.onerror = null;
            socket.close();
            reject(new PortError(code, this.url));
        };
        const timer = setTimeout(() => fail("no-answer"), OPEN_MS);

        this.#cancel = () => fail("nothing-there");
        socket.onerror = socket.onclose = this.#cancel;
        socket.onopen = () => {
            this.#cancel = null;
            clearTimeout(timer);
            this.#listen(socket);
            resolve();
        };
    }

    #listen(socket) {
        this.#socket = socket;
        socket.onerror = null;
        socket.onmessage = ({ data }) => typeof data !== "string" && this.onBytes(new Uint8Array(data)); // a frame of text has no bytes
        socket.onclose = ({ reason }) => {
            this.#socket = null;
            this.onClose(reason || "closed by the other end");
        };
    }

    write(bytes) {
        if (!this.#socket) throw new PortError("not-open");
        this.#socket.send(bytes);
    }

    async close() {
        const socket = this.#socket;

        this.#cancel?.();
        this.#socket = null;
        if (!socket) return;
        socket.onclose = socket.onmessage = null;
        socket.close();
    }
}
