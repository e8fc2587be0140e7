// SPDX-License-Identifier: MIT
/* Poses and sequences on the board: load, store, delete, play. store() sends several
 * commands. If one fails, store() deletes what it has stored and restores what it has replaced. If that fails too,
 * for example because the port is lost, the notice names what may be on the board.
 *
 * Throws MotionError, CommandError, WireError. */

import { pause } from "../wire/clock.js";
import { DEVICE } from "../wire/registers.js";
import { linesOfMotions, linesOfPose, linesOfSequence, readMotions } from "./motion_text.js";
import { JOINTS_MAX, MotionError, Motions, keywordsOf } from "./motions.js";

const ERROR_NO_GROUP = 45;
const ERROR_POSE_GONE = 78;
const REPLY_MS = 5000; // without a line of the reply
const READY_MS = 5000; // until a stop is over
const ROOM = /^poses: (\d+), room for (\d+); sequences: (\d+), room for (\d+)/;

export class MotionStore {
    #session;

    constructor(session) {
        this.#session = session;
        this.keywords = keywordsOf(session.tables);
        this.stored = new Motions({ keywords: this.keywords }); // what the board has, as last read
        this.gone = []; // names of sequences with a deleted pose
        this.names = []; // of all sequences; the number of a sequence is its place, from 1 on
        this.progress = 0; // of store(), 0 to 1
        this.room = null; // {poses, sequences} that still fit
    }

    get #controller() {
        return this.#session.controller;
    }

    /* True if the firmware stores poses and sequences. */
    get canStore() {
        return this.#session.isConnected && this.#controller.hasCommand("sequence");
    }

    /* True if the firmware plays them. */
    get canPlay() {
        return this.canStore && this.#controller.hasMotion;
    }

    /* The EEPROM is written for up to 0.9 s, and a motion begins within 1 s. */
    #run(line) {
        return this.#controller.run(line, { timeout: REPLY_MS });
    }

    /* Name of the sequence that the board plays, or "". */
    get playing() {
        return this.names[(this.#session.robot?.motion?.play ?? 0) - 1] ?? "";
    }

    /* ---- load ---- */

    /* Reads what the board has into `stored`. */
    async load() {
        const lines = [...(await this.#run("pose show")), ...(await this.#sequenceLines())];
        const { motions, gone } = readMotions(lines.join("\n"), { keywords: new Set() });

        motions.keywords = this.keywords;
        this.names = await this.#run("sequence list");
        this.room = await this.#readRoom();
        this.stored = motions;
        this.gone = gone;
        return motions;
    }

    /* The command ends with an error if a sequence names a deleted pose. */
    async #sequenceLines() {
        try {
            return await this.#run("sequence show");
        } catch (error) {
            if (error.number !== ERROR_POSE_GONE) throw error;
            return error.lines;
        }
    }

    async #readRoom() {
        const lines = await this.#run("status");
        const match = lines.map((line) => ROOM.exec(line)).find((found) => found);

        return match ? { poses: Number(match[2]), sequences: Number(match[4]) } : null;
    }

    /* ---- store ---- */

    /* The part of `motions` that the board does not have, or has with other contents. Call load() first. */
    newOf(motions, stored = this.stored) {
        const part = new Motions({ keywords: this.keywords });
        const isNew = (kept, lines) => ([name, now]) => !kept.has(name) || String(lines(name, now)) !== String(lines(name, kept.get(name)));

        part.poses = new Map([...motions.poses].filter(isNew(stored.poses, linesOfPose)));
        part.sequences = new Map([...motions.sequences].filter(isNew(stored.sequences, linesOfSequence)));
        return part;
    }

    /* Names that the board has with other contents, which are not those of `known` either. Call load() first. */
    replaced(motions, known) {
        const { poses, sequences } = this.newOf(motions);
        const other = this.newOf(this.stored, known);

        return [
            ...[...poses.keys()].filter((name) => other.poses.has(name)),
            ...[...sequences.keys()].filter((name) => other.sequences.has(name) || this.gone.includes(name)),
        ];
    }

    /* Stores poses and sequences, in place of those of the same name. Call load() first. Throws before it sends
     * anything if the board cannot take them all. */
    async store(motions) {
        this.#checkRoom(motions);
        const touched = { poses: new Set(), sequences: new Set() };
        const { stored } = this;
        const lines = linesOfMotions(motions);
        const before = await this.#group();

        try {
            for (const [index, line] of lines.entries()) {
                this.progress = index / lines.length;
                this.#session.dispatchEvent(new Event("change"));
                await this.#storeLine(line, touched);
            }
            await this.#checkKept(motions);
        } catch (error) {
            await this.#takeBack(touched, stored, error);
            throw error;
        } finally {
            if (before) await this.#run(before).catch(() => {});
        }
    }

    /* `names`: ["pose NAME", "sequence NAME"]. Sequences go first: they need the poses. */
    async remove(names) {
        for (const name of names.toReversed()) await this.#run(name.replace(" ", " delete "));
        await this.load();
    }

    #checkRoom(motions) {
        const { stored, room } = this;
        const isNew = (kept) => ([name]) => !kept.has(name) && !this.gone.includes(name);

        motions.check();
        if (this.#session.robot.motion?.state) throw new MotionError("motion-playing");
        const joints = new Set([...stored.joints, ...motions.joints]);

        if (joints.size > JOINTS_MAX) throw new MotionError("motion-joints", { count: joints.size });
        const poses = [...motions.poses].filter(isNew(stored.poses)).length;
        const sequences = [...motions.sequences].filter(isNew(stored.sequences)).length;

        if (room && (poses > room.poses || sequences > room.sequences)) throw new MotionError("motion-room", { room, poses, sequences });
    }

    /* The line that chooses the present group; "": there is none. */
    async #group() {
        try {
            return (await this.#run("group"))[0] ?? "";
        } catch (error) {
            if (error.number === ERROR_NO_GROUP) return "";
            throw error;
        }
    }

    /* A name counts as touched before its line is sent: the reply may be lost. */
    async #storeLine(line, touched) {
        const [command, ...words] = line.split(" ");

        if (command === "pose") touched.poses.add(words[1]);
        if (command === "sequence") touched.sequences.add(words[0]);
        await this.#run(line);
    }

    async #checkKept(motions) {
        await this.load();
        const { poses, sequences } = this.newOf(motions);
        const names = [...poses.keys(), ...sequences.keys()];

        if (names.length) throw new MotionError("motion-not-kept", { names });
    }

    /* Puts back what was there before, `stored`. `error`: why. */
    async #takeBack({ poses, sequences }, stored, error) {
        const { wire, clock } = this.#session;
        const left = new Set([...poses, ...sequences]);

        try {
            await Promise.race([wire.whenReady(), pause(clock, READY_MS)]);
            for (const name of sequences) if (!stored.sequences.has(name)) await this.#remove("sequence", name, left);
            for (const name of poses) await this.#putBack(name, stored.poses.get(name), left);
            for (const name of sequences)
                if (stored.sequences.has(name)) {
                    for (const line of linesOfSequence(name, stored.sequences.get(name))) await this.#run(line);
                    left.delete(name);
                }
            await this.load();
            this.#session.notify({ code: "motion-taken-back" });
        } catch {
            this.#session.notify({ code: "motion-half", names: [...left], why: error.message });
        }
    }

    async #putBack(name, pose, left) {
        if (!pose) {
            await this.#remove("pose", name, left);
            return;
        }
        for (const line of linesOfPose(name, pose)) await this.#run(line);
        left.delete(name);
    }

    /* Deletes what may be there: the line that stored it may have failed. */
    async #remove(kind, name, left) {
        const names = await this.#run(`${kind} list`);

        if (names.includes(name)) await this.#run(`${kind} delete ${name}`);
        left.delete(name);
    }

    /* ---- play ---- */

    /* Plays a stored sequence. `times` 0: until it is ended. */
    async play(name, { times = 1, percent = 100 } = {}) {
        const steps = this.stored.sequences.get(name);
        const ids = [...new Set(steps.flatMap(({ pose }) => [...this.stored.poses.get(pose).keys()]))];
        const how = times === 0 ? " loop" : times > 1 ? ` times ${times}` : "";

        await this.#controller.order(`group ${ids.join(" ")}`, { timeout: REPLY_MS });
        await this.#controller.order(`play ${name}${how} at ${percent}%`, { timeout: REPLY_MS });
    }

    setPaused = (isPaused) => this.#write(DEVICE.MOTION_PAUSE, Number(isPaused));
    end = () => this.#write(DEVICE.MOTION_PLAY, 0);
    override = (percent) => this.#write(DEVICE.MOTION_OVERRIDE, percent);

    async #write(register, value) {
        if (await this.#controller.writeDevice(register, [value])) throw new MotionError("motion-none");
    }
}
