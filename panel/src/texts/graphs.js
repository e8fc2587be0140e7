// SPDX-License-Identifier: MIT
/* The view Graphs. */

export const graphs = {
    notConnected: "Connect to a controller, or to the simulator, to record the servos.",
    noServo: "Choose a servo.",
    servos: "Servos",
    all: "All",
    none: "None",
    quantities: "Graphs",
    servo: "Servo ",
    goal: "goal ",
    dotted: "dotted: goal",
    names: { position: "Position", speed: "Speed", load: "Load", voltage: "Voltage", temperature: "Temperature" },
    units: { position: "°", speed: "rpm, +: counterclockwise", load: "%, +: the load pushes counterclockwise", voltage: "V", temperature: "°C" },
    pause: "Pause",
    goOn: "Resume",
    span: "Show",
    spanOf: (seconds) => (seconds < 60 ? `${+seconds.toFixed(1)} s` : `${+(seconds / 60).toFixed(1)} min`),
    zoomIn: { sign: "+", label: "Zoom in" },
    zoomOut: { sign: "−", label: "Zoom out" },
    earlier: { sign: "←", label: "Earlier" },
    later: { sign: "→", label: "Later" },
    save: "Save as CSV",
    saveHint: "Saves the chosen servos and graphs, and the time on the screen",
    hint: "Drag in a graph to zoom.",
    paused: "Paused. Recording goes on. A double click shows the present again.",
};
