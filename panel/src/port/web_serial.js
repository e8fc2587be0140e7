// SPDX-License-Identifier: MIT
/* A serial port of this machine (Web Serial: Chrome and Edge, https or localhost).
 *
 * All ports have one interface: open(), write(bytes, isStop), close(), the fields onBytes(bytes) and
 * onClose(reason), and `name`. write() returns at once and keeps the order. onClose() is called once, when the port is lost;
 * close() does not call it.
 *
 * With isStop, write() drops the earlier writes that wait in the page, and returns them. Only Web Serial can: a WebSocket
 * sends all that it has taken, so Ctrl-X follows what waits in the browser. */

const DRAIN_MS = 1000; // a port that takes nothing is then closed all the same

export class PortError extends Error {
    /* `code` names an entry of texts.port. */
    constructor(code, detail = "") {
        super(detail ? `${code}: ${detail}` : code);
        this.name = "PortError";
        this.code = code;
        this.detail = detail;
    }
}

export class WebSerialPort {
    #serial;
    #port = null;
    #reader = null;
    #writer = null;
    #readLoop = null; // ends when the last read has ended
    #isLost = false;
    #sending = Promise.resolve(); // ends when the port has taken all writes
    #queue = null; // writes behind the one that the port has not taken yet; null: there is none

    /* `serial`: navigator.serial or a fake of it. */
    constructor({ baudRate = 115200, serial = globalThis.navigator?.serial } = {}) {
        this.#serial = serial;
        this.baudRate = baudRate;
        this.name = `serial port, ${baudRate} bit/s`;
        this.onBytes = () => {};
        this.onClose = () => {};
    }

    static isSupported(serial = globalThis.navigator?.serial) {
        return Boolean(serial);
    }

    /* Lets the user choose a port; must be called from a click. Throws PortError. */
    async open() {
        let port;

        if (!this.#serial) throw new PortError("unsupported");
        try {
            port = await this.#serial.requestPort();
        } catch (error) {
            throw new PortError(error.name === "NotFoundError" ? "not-chosen" : "denied", error.message);
        }
        try {
            await port.open({ baudRate: this.baudRate, bufferSize: 4096 });
        } catch (error) {
            throw new PortError("in-use", error.message);
        }
        this.#port = port;
        this.#isLost = false;
        this.#queue = null;
        this.#writer = this.#port.writable.getWriter();
        this.#readLoop = this.#read();
    }

    write(bytes, isStop = false) {
        if (!this.#writer) throw new PortError("not-open");
        const dropped = isStop ? this.#queue?.splice(0) : [];

        if (this.#queue) this.#queue.push(bytes);
        else this.#sending = this.#send(this.#writer, bytes);
        return dropped;
    }

    /* One write at a time: what a stream has taken cannot be dropped. */
    async #send(writer, bytes) {
        const queue = (this.#queue = []);

        try {
            for (let next = bytes; next; next = queue.shift()) await writer.write(next);
            if (queue === this.#queue) this.#queue = null;
        } catch (error) {
            if (writer === this.#writer) this.#reportLoss(error.message);
        }
    }

    /* A framing error ends a stream but not the port: the next stream goes on. */
    async #read() {
        const port = this.#port;

        while (this.#port === port && port.readable) {
            this.#reader = port.readable.getReader();
            try {
                await this.#readStream(this.#reader);
            } catch (error) {
                if (!port.readable) this.#reportLoss(error.message);
            } finally {
                this.#reader.releaseLock();
                this.#reader = null;
            }
        }
        if (this.#port === port) this.#reportLoss("the port ended");
    }

    async #readStream(reader) {
        for (;;) {
            const { value, done } = await reader.read();

            if (done) return;
            if (value?.length) this.onBytes(value);
        }
    }

    #reportLoss(reason) {
        if (!this.#port || this.#isLost) return;
        this.#isLost = true;
        this.close();
        this.onClose(reason);
    }

    async close() {
        const port = this.#port;

        this.#port = null;
        if (!port) return;
        const writer = this.#writer;

        this.#writer = null;
        await this.#reader?.cancel().catch(() => {});
        await this.#finishWriting(writer);
        if (!this.#isLost) await this.#readLoop;
        await port.close().catch(() => {});
    }

    /* close() of the port would drop what has not left yet; close() of the writer waits for it. */
    async #finishWriting(writer) {
        const end = this.#isLost ? writer.abort() : this.#sending.then(() => writer.close());

        await Promise.race([end.catch(() => {}), new Promise((resolve) => setTimeout(resolve, DRAIN_MS))]);
        try {
            writer.releaseLock();
        } catch {
            /* the stream has failed; the port is closed all the same */
        }
    }
}
