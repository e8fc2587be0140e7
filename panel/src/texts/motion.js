// SPDX-License-Identifier: MIT
/* The view Motion, and its notices. */

import { list, many } from "./words.js";

export const motion = {
    notConnected: "Connect to a controller, or to the simulator, to teach and play. Poses and sequences can be edited without it.",
    noStore: "This firmware stores no poses and sequences. They stay in this page: save them as a file. The page itself plays them.",
    noPlay: "This board stores poses and sequences, and has no room to play them. The page itself plays them.",

    noValue: "–",
    teach: "Teach",
    servos: "Servos",
    all: "All",
    none: "None",
    torqueOff: "Torque off",
    torqueOffHint: "The chosen servos go limp: support the robot",
    hold: "Hold",
    holdHint: "Torque on, where the chosen servos are now",
    noServos: "No servo is known. Find servos in the view Robot.",
    isLimp: (id) => `Servo ${id}, torque off`,
    isHeld: (id) => `Servo ${id}, torque on`,
    isUnknown: (id) => `Servo ${id}, torque not known`,
    poseName: "Name of the pose",
    nameHint: "A letter, then letters and digits, up to 8 characters, no word of the console",
    capture: "Capture pose",
    captureHint: "Keeps where the chosen servos are now",
    record: "Record",
    recordHint: "Switch torque off, then lead the chosen servos by hand",
    endRecording: "End recording",

    poses: "Poses",
    noPoses: ["Choose servos and press “Torque off”.", "Turn them by hand.", "Press “Capture pose”, once for each pose."],
    goTo: "Go there",
    goToOf: (name) => `Go to pose ${name}`,
    editOf: (name) => `Edit pose ${name}`,
    deletePoseOf: (name) => `Delete pose ${name}`,
    servosOf: (pose) => many(pose.size, "servo"),
    angle: (id) => `Servo ${id}`,
    angleOut: (id) => `Take servo ${id} out of the pose`,
    fromServos: "Take present positions",
    name: "Name",

    recording: "Recording",
    recordingIs: ({ seconds, samples, rate, servos }) =>
        `${seconds} s of ${many(servos, "servo")}, ${samples} samples, ${rate} a second`,
    missing: (count) => `${many(count, "position is", "positions are")} missing`,
    tolerance: "Error of the steps, at most",
    fit: "Fit into one sequence",
    fitHint: "As many steps as a sequence of the board takes: 16",
    thinned: ({ steps, error, board }) => `${many(steps, "step")}. Error: ${error}° if the page replays them, ${board}° as a sequence of the board.`,
    replay: "Replay",
    replayHint: "The page sends the recording as goals, once, at the Speed of the box Play",
    replayThinned: "Replay the steps",
    replayed: ({ largest, id, mean }) => `Replay: largest error ${largest}° (servo ${id}), mean ${mean}°`,
    toSequence: "Make a sequence of the steps",
    saveRecording: "Save as CSV",

    sequence: "Sequence",
    choose: "Sequence",
    noSequence: "none yet",
    noSequences: "Add a step to begin a sequence.",
    noPosesYet: "First capture poses in the box Teach, or open a file. Then add a step.",
    newSequence: "New",
    deleteSequence: "Delete sequence",
    step: "Step",
    pose: "Pose",
    time: "Time, s",
    dwell: "Rest, s",
    pass: "Pass",
    passHint: "Pass: goes through the pose without a stop",
    addStep: "Add step",
    stepsHint: "Time: from the pose before; in step 1 from where the servos are. Rest: the wait at the pose. Pass: no stop there. A click in the curves chooses a step.",
    up: "Up",
    down: "Down",
    remove: "Remove",
    ofStep: (what, number) => `${what}, step ${number}`,
    chart: "Curves of the sequence",
    chartText: ({ steps, seconds, servos }) => `${many(steps, "step")}, ${seconds} s, ${many(servos, "servo")}`,
    chartOfRecording: "Curves of the recording and of its replay",
    tooFast: ({ step, id, needed }) => `Step ${step}: servo ${id} needs ${needed} s.`,

    player: "Play",
    where: "Played by",
    byBoard: "the board",
    byPage: "this page",
    times: "Times",
    loop: "Loop",
    override: "Speed",
    play: "Play",
    pause: "Pause",
    resume: "Resume",
    end: "End",
    idle: "Nothing plays.",
    begins: "A motion begins.",
    boardPlays: ({ name, step, steps, paused }) =>
        `${name || "A move"} plays${step ? `: step ${step}${steps ? " of " + steps : ""}` : ""}${paused ? ", paused" : ""}.`,
    pageBegins: "The servos go to the start position.",
    pagePlays: ({ seconds, paused }) => `The page plays: ${seconds} s${paused ? ", paused" : ""}.`,

    board: "Board and files",
    store: "Store on the board",
    load: "Load from the board",
    exportFile: "Save as a file",
    importFile: "Open a file",
    room: ({ poses, sequences }) => `Free on the board: ${many(poses, "pose")}, ${many(sequences, "sequence")}.`,
    storing: "Storing …",
    loading: "Loading …",
    askReplaceBoard: (names) => `The board has other contents under these names: ${names.join(", ")}. Replace them?`,
    askReplacePage: "Poses and sequences of this page were changed and not stored or saved. Replace them?",
    replace: "Replace",
    cancel: "Cancel",
};

const inLine = (line) => (line ? `Line ${line}: ` : "");

export const motionNotices = {
    "motion-name": ({ detail, line }) => ({
        text: `${inLine(line)}“${detail}” is not a name.`,
        remedy: "Give a letter, then letters and digits, up to 8 characters.",
    }),
    "motion-name-long": ({ detail, line }) => ({
        text: `${inLine(line)}the name “${detail}” is too long.`,
        remedy: "Give at most 8 characters.",
    }),
    "motion-name-keyword": ({ detail, line }) => ({
        text: `${inLine(line)}the name “${detail}” is a word of the console.`,
        remedy: "Choose another name.",
    }),
    "motion-twice": ({ detail }) => ({ text: `The name “${detail}” is taken.`, remedy: "Choose another name." }),
    "motion-pose-empty": ({ detail }) => ({
        text: `Pose “${detail}” would have no servo.`,
        remedy: "Choose servos whose positions are known.",
    }),
    "motion-angle": ({ detail }) => ({ text: `An angle is out of range: ${detail}.`, remedy: "Give 0 to 300 degrees." }),
    "motion-deleted": ({ detail }) => ({ text: `${detail} is deleted.`, remedy: "", level: "info" }),
    "motion-pose-used": ({ detail, users }) => ({
        text: `Pose “${detail}” is a step of ${users.join(", ")}.`,
        remedy: "Remove these steps first.",
    }),
    "motion-steps": ({ detail, count }) => ({
        text: `Sequence “${detail}” would have ${count} steps. The board takes 16.`,
        remedy: "Remove steps, begin another sequence, or permit a larger error.",
    }),
    "motion-no-steps": ({ detail }) => ({
        text: `Sequence “${detail}” has no step.`,
        remedy: "Add a step, or delete the sequence.",
    }),
    "motion-no-pose": ({ detail, pose, line }) => ({
        text: `${inLine(line)}there is no pose “${pose}” (${detail}).`,
        remedy: "Capture this pose first. In a file its line stands before the sequence.",
    }),
    "motion-time": ({ detail, line }) => ({
        text: `${inLine(line)}a time is out of range${detail ? ": " + detail : ""}.`,
        remedy: "Give 0.01 to 600 s.",
    }),
    "motion-dwell": ({ detail, line }) => ({
        text: `${inLine(line)}a rest is out of range${detail ? ": " + detail : ""}.`,
        remedy: "Give 0 to 65.53 s.",
    }),
    "motion-time-step": ({ detail, line }) => ({
        text: `${inLine(line)}a time is not a multiple of 0.01 s${detail ? ": " + detail : ""}.`,
        remedy: "The board stores times in steps of 0.01 s.",
    }),
    "motion-joints": ({ count }) => ({
        text: `The poses have ${count} servos. The board stores poses of 18 servos.`,
        remedy: "Delete poses, here or on the board, or take servos out of them.",
    }),
    "motion-unanswered": () => ({
        text: "The controller did not answer in time. The page sends no more goals.",
        remedy: "Check the cable and the rate, then play again.",
    }),
    "motion-file": ({ line, why }) => ({
        text: `Line ${line} of the file is damaged: ${why}. Nothing was loaded.`,
        remedy: "Choose a file that this page has saved, or lines of “pose show” and “sequence show”.",
    }),
    "motion-file-empty": () => ({
        text: "The file has neither poses nor sequences. Nothing was loaded.",
        remedy: "Choose a file that this page has saved, or lines of “pose show” and “sequence show”.",
    }),
    "motion-gone": ({ names }) => ({
        text: `Not loaded: ${names.join(", ")}. A step names a pose that was deleted.`,
        remedy: "Store the sequence again, or delete it on the board with “sequence delete”.",
        level: "warning",
    }),
    "motion-room": ({ poses, sequences, room }) => ({
        text: `The board has room for ${room.poses} poses and ${room.sequences} sequences; this needs ${poses} and ${sequences}. Nothing was stored.`,
        remedy: "Delete poses or sequences on the board with “pose delete” and “sequence delete”.",
    }),
    "motion-stored": ({ poses, sequences }) => ({
        text: `The board has confirmed ${many(poses, "pose")} and ${many(sequences, "sequence")}.`,
        remedy: "",
        level: "info",
    }),
    "motion-loaded": ({ poses, sequences }) => ({
        text: `Loaded: ${many(poses, "pose")} and ${many(sequences, "sequence")}.`,
        remedy: "",
        level: "info",
    }),
    "motion-taken-back": () => ({
        text: "Not all could be stored. The board has what it had before: what this action had stored was deleted again.",
        remedy: "Remove the cause, then store again.",
        level: "warning",
    }),
    "motion-half": ({ names, why }) => ({
        text: `Storing has ended (${why}), and it is not known what the board has of these: ${names.join(", ")}.`,
        remedy: "Connect again, then store again.",
    }),
    "motion-not-kept": ({ names }) => ({
        text: `The board does not have what was stored: ${names.join(", ")}.`,
        remedy: "Store again. If it happens again, the EEPROM may be worn: see “status”.",
    }),
    "motion-not-stored": ({ detail }) => ({
        text: `The board has no sequence “${detail}”.`,
        remedy: "Press “Store on the board” first, or let this page play it.",
    }),
    "motion-none": () => ({
        text: "The controller has refused this: no motion is under way, or the EEPROM is being written.",
        remedy: "See the state of the motion, then try again.",
    }),
    "motion-ended": ({ id, number, message, remedy }) => ({
        text: `${id ? `Servo ${id}: the` : "The"} motion has ended with error ${number}: ${message}.`,
        remedy,
    }),
    "motion-board-plays": () => ({ text: "The board plays a motion.", remedy: "End it, or wait for its end." }),
    "motion-playing": () => ({ text: "The page plays already.", remedy: "End it, or wait for its end." }),
    "motion-disconnected": () => ({ text: "There is no connection to the controller.", remedy: "Connect again." }),
    "motion-inhibited": () => ({
        text: "Driving is inhibited. The page sends no goals.",
        remedy: "Remove the cause, press Release, then switch torque on.",
    }),
    "motion-torque": ({ ids }) => ({
        text: `Torque is not on: ${list(ids)}. The page sends no more goals.`,
        remedy: "Choose these servos and press “Hold”.",
    }),
    "motion-endless": ({ ids }) => ({
        text: `Endless turn: ${list(ids)}. Such a servo has no position to go to.`,
        remedy: "Set its angle limits, or leave it out.",
    }),
    "motion-not-there": ({ ids }) => ({
        text: `Did not reach the start position in time: ${list(ids)}. Nothing was played.`,
        remedy: "Look for what blocks the servo, and for its angle limits.",
    }),
    "motion-late": () => ({
        text: "The page was held up, and late goals are not sent. The replay has ended; the servos hold their last goals.",
        remedy: "Keep this page in front, then play again.",
    }),
    "motion-not-asked": () => ({
        text: "Nothing was replaced: the view Motion was left before the page could ask.",
        remedy: "Start it again, and stay in the view until it has ended.",
    }),
    "motion-busy": () => ({
        text: "Goals could not leave, since a command had the wire. The page sends no more goals; the servos hold their last ones.",
        remedy: "Let the command end, or end it. Then play again.",
    }),
    "motion-none-chosen": () => ({ text: "No servo is chosen.", remedy: "Choose servos in the box Teach." }),
    "motion-offline": ({ ids }) => ({
        text: `No fresh position: ${list(ids)}. Nothing was kept.`,
        remedy: "Check power and wiring, or leave these servos out.",
    }),
    "motion-no-poses": () => ({ text: "There is no pose for a step.", remedy: "Press “Capture pose” first." }),
    "motion-empty": () => ({ text: "There is nothing to store.", remedy: "Capture a pose first." }),
    "motion-differs": ({ detail }) => ({
        text: `The board has other contents for “${detail}” than this page.`,
        remedy: "Press “Store on the board”, or let this page play it.",
    }),
    "motion-record-cut": () => ({
        text: "The recording has ended, since the connection is lost.",
        remedy: "Connect again, then record again if a part is missing.",
    }),
    "motion-short": () => ({
        text: "The recording is too short.",
        remedy: "Lead the servos by hand while the page records.",
    }),
};
