// SPDX-License-Identifier: MIT
/* Gives the user a file to save. */

export function saveFile(name, text, type = "text/plain") {
    const link = document.createElement("a");

    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = name;
    link.click();
    URL.revokeObjectURL(link.href);
}
