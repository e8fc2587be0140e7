// SPDX-License-Identifier: MIT
/* A card for each servo: dial, values, torque. A drag at the dial sets the goal. Left and Right jog the
 * servo whose dial has the focus, while the key is held; Up, Down and Page keys step its goal. Digits
 * choose a servo. */

import { html, nothing } from "lit/html.js";
import { live } from "lit/directives/live.js";
import { repeat } from "lit/directives/repeat.js";
import { takesText } from "../keys.js";
import { degreesAt, degreesOfDrag } from "../model/dial.js";
import { Jog } from "../model/jog.js";
import { GOAL_RPM } from "../model/robot.js";
import { DEGREES_MAX, RPM_MAX } from "../model/units.js";
import { texts } from "../texts/texts.js";
import { servo as nameOf } from "../texts/words.js";
import { dialDrawing, pointIn, VIEW_BOX } from "./dial.js";
import { View } from "./view.js";

const t = texts.robot;
const SPEEDS = [5, 10, 20, 40, 60]; // rpm
const TICK_MS = 500; // values get old without an event
const DIGITS_MS = 1500; // two digits that come later are two numbers
const SMALL_STEP = 1; // degrees
const GREAT_STEP = 10;
const TOUCH_STEPS = [GREAT_STEP, SMALL_STEP, -SMALL_STEP, -GREAT_STEP];
const JOG_RPM = 10; // at most: a jog is for the last degrees
const BOX = `${VIEW_BOX.left} ${VIEW_BOX.top} ${VIEW_BOX.width} ${VIEW_BOX.height}`;
const STEPS = { ArrowUp: SMALL_STEP, ArrowDown: -SMALL_STEP, PageUp: GREAT_STEP, PageDown: -GREAT_STEP };
const JOGS = { ArrowLeft: 1, ArrowRight: -1 }; // as the hand turns at the top of the dial

const WITH_DIAGNOSIS = [t.allSilent, t.lineLow].map((text) => html`${text} <a href="#setup">${texts.setup.diagnosis}</a>`);
const shown = (value, digits, unit) => (value === null ? t.noValue : `${value.toFixed(digits)}${unit}`);
const within = (servo, degrees) => Math.min(Math.max(degrees, servo.low ?? 0), servo.high ?? DEGREES_MAX);

export class RobotView extends View {
    #jog = null;
    #jogKey = "";
    #drag = null; // {id, degrees, top}; top: where its dial is on the screen
    #pendingGoals = new Map(); // by servo ID: the goal that a user asked for last, in degrees
    #ignored = new Set(); // IDs of servos whose drag was ignored, since torque is off
    #turns = new Map(); // by servo ID: the slider of a servo in an endless turn
    #isHeld = false; // a key or a pointer at the slider of an endless turn
    #digits = { text: "", at: 0 };
    #ticker = null;
    #onKey = (event) => this.#chooseByDigit(event);
    #onBlur = () => this.#endMoves();
    #onChange = () => {
        const { session } = this;

        if (!session.isConnected) this.found = 0;
        if (!session.isConnected || session.stopState === "stopping" || session.robot.isInhibited) this.#letGo();
    };

    constructor() {
        super();
        this.rpm = GOAL_RPM;
        this.found = 0; // servos that the last search has found; told until another number answers
    }

    connectedCallback() {
        super.connectedCallback();
        this.#jog ??= new Jog(this.session);
        this.#ticker = setInterval(() => this.requestUpdate(), TICK_MS);
        this.#listen("addEventListener");
    }

    disconnectedCallback() {
        super.disconnectedCallback();
        this.#endMoves();
        clearInterval(this.#ticker);
        this.#listen("removeEventListener");
    }

    #listen(how) {
        this.session[how]("change", this.#onChange);
        document[how]("keydown", this.#onKey);
        document[how]("visibilitychange", this.#onBlur);
        globalThis[how]("blur", this.#onBlur);
    }

    /* ---- goals ---- */

    #setGoal(servo, degrees) {
        const isTaken = this.session.robot.setGoal(servo.id, degrees, this.rpm);

        if (isTaken) this.#pendingGoals.set(servo.id, degrees);
        this.#tellIgnored(servo, isTaken);
        return isTaken;
    }

    #tellIgnored({ id }, isTaken) {
        if (isTaken) this.#ignored.delete(id);
        else this.#ignored.add(id);
        this.requestUpdate();
    }

    /* The goal that is asked for and not confirmed yet, or null. */
    #pendingGoalOf({ id, goalState }) {
        return this.#drag?.id === id || goalState === "waiting" ? (this.#pendingGoals.get(id) ?? null) : null;
    }

    /* ---- pointer ---- */

    #grab(servo, event) {
        if (event.button) return; // a right or middle click asks for no goal
        const dial = event.currentTarget.ownerSVGElement;
        const { x, y } = pointIn(dial, event);
        const degrees = within(servo, degreesAt(x, y));

        event.preventDefault(); // selects no text
        dial.focus({ focusVisible: false });
        if (!this.#setGoal(servo, degrees)) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        this.#drag = { id: servo.id, degrees, top: dial.getBoundingClientRect().top };
    }

    #pull(servo, event) {
        const dial = event.currentTarget.ownerSVGElement;

        // The button was released where the page did not see it, or a card above has grown.
        if (!event.buttons || this.#drag?.top !== dial.getBoundingClientRect().top) this.#letGo();
        if (this.#drag?.id !== servo.id) return;
        const { x, y } = pointIn(dial, event);

        this.#drag.degrees = within(servo, degreesOfDrag(this.#drag.degrees, x, y));
        this.#setGoal(servo, this.#drag.degrees);
    }

    #letGo() {
        if (!this.#drag) return;
        this.#drag = null;
        this.requestUpdate();
    }

    /* ---- keys ---- */

    #key(servo, event) {
        if (event.ctrlKey || event.altKey || event.metaKey) return;
        const step = STEPS[event.key];
        const end = { Home: servo.low ?? 0, End: servo.high ?? DEGREES_MAX }[event.key];

        if (step) this.#step(servo, step);
        else if (end !== undefined) this.#setGoal(servo, end);
        else if (JOGS[event.key]) this.#beginJog(servo, event);
        else return;
        event.preventDefault(); // the page would scroll
    }

    #step(servo, step) {
        this.#setGoal(servo, within(servo, (this.#pendingGoalOf(servo) ?? servo.goal ?? servo.position ?? 0) + step));
    }

    #beginJog(servo, event) {
        if (event.repeat) return;
        this.#jogKey = event.key;
        this.#pendingGoals.delete(servo.id); // the goals of the jog are not those of the last drag
        this.#tellIgnored(servo, this.#jog.start(servo.id, JOGS[event.key], Math.min(this.rpm, JOG_RPM)));
    }

    #keyUp(event) {
        if (event.key === this.#jogKey) this.#endJog();
    }

    #endJog() {
        this.#jogKey = "";
        this.#jog?.stop();
    }

    /* Digits choose the servo with this ID. */
    #chooseByDigit(event) {
        if (!/^\d$/.test(event.key) || event.ctrlKey || event.altKey || event.metaKey || takesText(event.target)) return;
        const isMore = event.timeStamp - this.#digits.at < DIGITS_MS;
        const find = (text) => this.querySelector(`[data-id="${Number(text)}"] .chosen-by-number`);

        this.#digits = { text: isMore ? this.#digits.text + event.key : event.key, at: event.timeStamp };
        (find(this.#digits.text) ?? find(event.key))?.focus();
    }

    /* ---- endless turn ---- */

    #turn(servo, { target }) {
        const isTaken = this.session.robot.setTurn(servo.id, -Number(target.value)); // left is counterclockwise

        if (isTaken) this.#turns.set(servo.id, target);
        else target.value = 0;
        this.#tellIgnored(servo, isTaken);
    }

    /* Without a key or a pointer that is held, as by a screen reader, the turn ends at once. */
    #endTurn({ id }) {
        const slider = this.#turns.get(id);

        this.#isHeld = false;
        if (!this.#turns.delete(id)) return;
        slider.value = 0;
        this.session.attempt(() => this.session.robot.hold(id));
    }

    #turnKeyUp(servo, { key }) {
        if (key !== "Tab") this.#endTurn(servo);
    }

    /* The page or the view is left: nothing that a user holds goes on. */
    #endMoves() {
        this.#endJog();
        this.#letGo();
        for (const id of this.#turns.keys()) this.#endTurn({ id });
    }

    /* ---- torque, search, alarms ---- */

    #setTorque(servo, { target }) {
        const isOn = target.checked;

        target.checked = servo.torque === true; // shown as on only when the servo has confirmed it
        this.#ignored.delete(servo.id);
        this.session.attempt(() => this.session.robot.setTorque(servo.id, isOn));
    }

    #setTorqueAll(isOn) {
        const { session } = this;

        this.#ignored.clear();
        session.attempt(() => session.robot.setTorqueAll(isOn, (error) => session.notify(error)));
    }

    #find = async () => {
        this.isFinding = true;
        this.requestUpdate();
        this.found = 0;
        await this.session.attempt(async () => {
            await this.session.robot.findServos({ how: "" });
            this.found = this.session.robot.answering;
        });
        this.isFinding = false;
        this.requestUpdate();
    };

    #releaseServo({ id }) {
        this.session.attempt(async () => {
            await this.session.controller.order(`release ${id}`);
            this.session.takeRelease(id);
        });
    }

    /* ---- parts of the view ---- */

    #toolbar(servos, notes) {
        const { robot } = this.session;
        const hasAlarms = Boolean(robot.device?.alarms) || servos.some(({ alarms }) => alarms.length);

        return html`<div class="toolbar">
            <button class="torque-on" ?disabled=${!servos.length} @click=${() => this.#setTorqueAll(true)}>${t.allOn}</button>
            <button class="torque-off" ?disabled=${!servos.length} @click=${() => this.#setTorqueAll(false)}>${t.allOff}</button>
            <label>
                ${t.speedOfMoves}
                <select class="pace" @change=${({ target }) => (this.rpm = Number(target.value))}>
                    ${SPEEDS.map((rpm) => html`<option value=${rpm} ?selected=${rpm === this.rpm}>${rpm} rpm</option>`)}
                </select>
            </label>
            <button class="find" ?disabled=${this.isFinding} @click=${this.#find}>${this.isFinding ? t.finding : t.find}</button>
            <span role="status">${this.found === robot.answering ? t.found(this.found) : ""}</span>
            ${hasAlarms
                ? html`<button class="clear-alarms" @click=${() => this.session.attempt(() => robot.clearAlarms())}>
                      ${t.clearAlarms}
                  </button>`
                : nothing}
            ${this.#hints(notes)}
        </div>`;
    }

    #dial(servo) {
        return html`<svg
            class="dial chosen-by-number"
            viewBox=${BOX}
            role="slider"
            tabindex="0"
            aria-label=${t.dialOf(servo.id)}
            aria-describedby="robot-keys"
            aria-valuemin=${(servo.low ?? 0).toFixed(0)}
            aria-valuemax=${(servo.high ?? DEGREES_MAX).toFixed(0)}
            aria-valuenow=${(servo.goal ?? 0).toFixed(1)}
            aria-valuetext=${t.dialValue(shown(servo.goal, 1, "°"), shown(servo.position, 1, "°"), servo.torque)}
            aria-disabled=${!servo.torque}
            @keydown=${(event) => this.#key(servo, event)}
            @keyup=${(event) => this.#keyUp(event)}
            @blur=${() => this.#endJog()}
        >
            <g
                @pointerdown=${(event) => this.#grab(servo, event)}
                @pointermove=${(event) => this.#pull(servo, event)}
                @lostpointercapture=${() => this.#letGo()}
            >
                ${dialDrawing(servo, this.#pendingGoalOf(servo))}
            </g>
            <text class="position" y="1">${shown(servo.position, 1, "°")}</text>
            <text class="goal" y="15">${servo.goal === null ? "" : `→ ${servo.goal.toFixed(1)}°`}</text>
        </svg>`;
    }

    /* Where there may be no keyboard. */
    #touchSteps(servo) {
        return html`<div class="touch">
            ${TOUCH_STEPS.map((step) => html`<button aria-label=${t.stepOf(servo.id, step)}
                @click=${() => this.#step(servo, step)}>${t.step(step)}</button>`)}
        </div>`;
    }

    #turnSlider(servo) {
        return html`<div class="turn">
            <p>${t.endless}</p>
            <output class="position">${shown(servo.position, 1, "°")}</output>
            <input
                class="chosen-by-number"
                type="range"
                aria-label=${t.turnOf(servo.id)}
                min=${-Math.floor(RPM_MAX)}
                max=${Math.floor(RPM_MAX)}
                value="0"
                ?disabled=${servo.torque !== true}
                @input=${(event) => this.#turn(servo, event)}
                @keydown=${() => (this.#isHeld = true)}
                @pointerdown=${() => (this.#isHeld = true)}
                @change=${() => this.#isHeld || this.#endTurn(servo)}
                @pointerup=${() => this.#endTurn(servo)}
                @pointercancel=${() => this.#endTurn(servo)}
                @keyup=${(event) => this.#turnKeyUp(servo, event)}
                @blur=${() => this.#endTurn(servo)}
            />
            <output class="goal">→ ${shown(servo.goalSpeed, 0, " rpm")}</output>
            <p class="hint">${t.turnHint}</p>
        </div>`;
    }

    #silenceOf({ hasOtherRate }) {
        const { robot } = this.session;

        if (!robot.isLineLow && (hasOtherRate || robot.answering)) return { advice: hasOtherRate ? t.otherRate : t.silentAdvice };
        return { advice: WITH_DIAGNOSIS[Number(robot.isLineLow)], namesNoServo: true };
    }

    /* What a user should know of this servo: [{level, text, advice, namesNoServo}]. The card shows `text`; the box above the
     * cards shows `advice`. namesNoServo: true if the advice is about the whole robot. */
    #notesOf(servo) {
        const { goalState } = servo;
        const notes = servo.alarms.map((name) => ({ level: "bad", text: t.alarm(name), advice: t.alarmAdvice(name) }));

        if (servo.presence === "offline") notes.push({ level: "bad", text: t.silent, ...this.#silenceOf(servo) });
        if (servo.inhibit) notes.push({ level: "warn", text: t.inhibited, advice: t[servo.inhibit], namesNoServo: servo.inhibit !== "lost" });
        if (this.#ignored.has(servo.id) && servo.torque !== true) notes.push({ level: "warn ignored", text: t.ignored, advice: t.ignoredAdvice });
        else if (t.goalStates[goalState]) notes.push({ level: "warn", text: t.goalStates[goalState], advice: t.goalAdvice[goalState] });
        return notes;
    }

    /* A screen reader tells a stop once, above the cards, and not for each card. */
    #notes(servo, notes) {
        return html`<div class="notes">
            <div class="texts" aria-live="polite">
                ${notes.map(({ level, text, namesNoServo }) => html`<p class="note ${level}" aria-live=${namesNoServo ? "off" : nothing}>${text}</p>`)}
            </div>
            ${servo.inhibit === "lost"
                ? html`<button aria-label=${t.releaseOf(servo.id)} @click=${() => this.#releaseServo(servo)}>${texts.stop.release}</button>`
                : nothing}
        </div>`;
    }

    /* Each advice once, with its servos. The box has a fixed height, so the cards stay where they are. */
    #hints(notes) {
        const servosOf = new Map();

        for (const [id, list] of notes)
            for (const { advice, namesNoServo } of list)
                if (advice) servosOf.set(advice, namesNoServo ? [] : [...(servosOf.get(advice) ?? []), id]);
        return html`<div class="hints">
            <p id="robot-keys" ?hidden=${servosOf.size || [...this.session.robot.servos.values()].every(({ isEndless }) => isEndless)}>${t.keys}</p>
            <div class="advice" role="status">
                ${[...servosOf].map(([advice, ids]) => html`<p>${ids.length ? `${nameOf({ id: ids[0], ids })}: ` : ""}${advice}</p>`)}
            </div>
        </div>`;
    }

    #card(servo, notes) {
        const isOld = servo.presence === "online" && servo.isOld(this.session.clock.now());
        const state = isOld ? "old" : servo.presence;
        const id = `servo-${servo.id}`;
        const row = (name, value) => html`<dt title=${texts.graphs.units[name]}>${texts.graphs.names[name]}</dt><dd>${value}</dd>`;

        return html`<article class="card ${state}" data-id=${servo.id} aria-labelledby=${id}>
            <div class="head">
                <h3 id=${id}>${t.servo} ${servo.id}</h3>
                <span class="state">${t[state]}</span>
                <label class="torque">
                    <input
                        type="checkbox"
                        aria-label=${t.torqueOf(servo.id)}
                        .checked=${live(servo.torque === true)}
                        .indeterminate=${live(servo.torque === null)}
                        ?disabled=${servo.presence !== "online"}
                        @change=${(event) => this.#setTorque(servo, event)}
                    />
                    ${t.torque}
                </label>
            </div>
            <div class="body">
                ${servo.isEndless ? this.#turnSlider(servo) : this.#dial(servo)}
                <dl>
                    ${row("speed", shown(servo.speed, 1, " rpm"))} ${row("load", shown(servo.load, 0, " %"))}
                    ${row("voltage", shown(servo.voltage, 1, " V"))} ${row("temperature", shown(servo.temperature, 0, " °C"))}
                </dl>
                ${servo.isEndless ? nothing : this.#touchSteps(servo)}
            </div>
            ${this.#notes(servo, notes)}
        </article>`;
    }

    render() {
        const { session } = this;

        if (!session.isConnected) return html`<p>${t.notConnected}</p>`;
        const servos = [...session.robot.servos.values()];
        const notes = new Map(servos.map((servo) => [servo.id, this.#notesOf(servo)]));

        return html`
            ${this.#toolbar(servos, notes)} ${servos.length ? nothing : html`<p>${t.none}</p>`}
            <div class="cards">${repeat(servos, ({ id }) => id, (servo) => this.#card(servo, notes.get(servo.id)))}</div>
        `;
    }
}

customElements.define("panel-robot", RobotView);
