/* SPDX-License-Identifier: MIT */
#include "avr/image.h"

#include <elf.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_eeprom.h>

#define DEVICE_NOTE   ".note.gnu.avr.deviceinfo"
#define EEPROM_BASE   0x810000u // avr-gcc's offsets of the address spaces
#define EEPROM_END    0x820000u
#define DATA_BASE     0x800000u
#define ARCH_MASK     0x7Fu // in e_flags
#define FILE_SIZE_MAX (16u << 20)

static bool refuse(const struct image *image, const char *what)
{
    fprintf(stderr, "%s: %s\n", image->path, what);
    return false;
}

static bool within(const struct image *image, uint64_t offset, uint64_t size)
{
    return offset + size <= image->size;
}

static Elf32_Ehdr header(const struct image *image)
{
    Elf32_Ehdr h;
    memcpy(&h, image->file, sizeof(h));
    return h;
}

static bool read_file(struct image *image, FILE *file)
{
    size_t capacity = 0;
    for (;;) {
        if (image->size == capacity) {
            capacity = capacity ? capacity * 2 : 1u << 16;
            uint8_t *bigger = realloc(image->file, capacity);
            if (!bigger || capacity > FILE_SIZE_MAX) {
                return refuse(image, "too big for an AVR program");
            }
            image->file = bigger;
        }
        size_t got = fread(image->file + image->size, 1, capacity - image->size, file);
        if (!got) {
            return !ferror(file) || refuse(image, strerror(errno));
        }
        image->size += got;
    }
}

static bool check_header(const struct image *image)
{
    if (image->size < sizeof(Elf32_Ehdr) || memcmp(image->file, ELFMAG, SELFMAG) != 0) {
        return refuse(image, "not an ELF file");
    }
    Elf32_Ehdr h = header(image);
    if (h.e_ident[EI_CLASS] != ELFCLASS32 || h.e_machine != EM_AVR || h.e_type != ET_EXEC) {
        return refuse(image, "not a linked program for an AVR");
    }
    if (!within(image, h.e_phoff, (uint64_t)h.e_phnum * sizeof(Elf32_Phdr)) ||
        !within(image, h.e_shoff, (uint64_t)h.e_shnum * sizeof(Elf32_Shdr))) {
        return refuse(image, "damaged ELF file");
    }
    return true;
}

bool image_open(struct image *image, const char *path)
{
    *image = (struct image){.path = path};
    FILE *file = fopen(path, "rb");
    if (!file) {
        return refuse(image, errno == ENOENT ? "No such file or directory; build it with make first"
                                             : strerror(errno));
    }
    bool good = read_file(image, file) && check_header(image);
    fclose(file);
    return good;
}

void image_close(struct image *image)
{
    free(image->file);
    image->file = 0;
}

static bool section(const struct image *image, const char *name, Elf32_Shdr *found)
{
    Elf32_Ehdr h = header(image);
    Elf32_Shdr names;
    if (h.e_shstrndx >= h.e_shnum) {
        return false;
    }
    memcpy(&names, image->file + h.e_shoff + h.e_shstrndx * sizeof(names), sizeof(names));
    for (unsigned i = 0; i < h.e_shnum; i++) {
        memcpy(found, image->file + h.e_shoff + i * sizeof(*found), sizeof(*found));
        uint64_t at = (uint64_t)names.sh_offset + found->sh_name;
        if (within(image, at, strlen(name) + 1) &&
            strcmp((const char *)image->file + at, name) == 0) {
            return within(image, found->sh_offset, found->sh_size);
        }
    }
    return false;
}

/* avr-libc's start-up code puts the chip's name at the end of a note. */
static void device_name(const struct image *image, char *name, size_t capacity)
{
    Elf32_Shdr note;
    name[0] = 0;
    if (!section(image, DEVICE_NOTE, &note)) {
        return;
    }
    const char *start = (const char *)image->file + note.sh_offset;
    const char *end = start + note.sh_size;
    while (end > start && end[-1] == 0) {
        end--;
    }
    const char *word = end;
    while (word > start && word[-1] != 0) {
        word--;
    }
    if ((size_t)(end - word) < capacity) {
        memcpy(name, word, (size_t)(end - word));
        name[end - word] = 0;
    }
}

/* Returns avr-gcc's number of the instruction set, which follows from the flash size (avr5, avr51,
 * avr6). */
static unsigned architecture(const avr_t *avr)
{
    return avr->flashend >= 0x20000 ? 6 : avr->flashend >= 0x10000 ? 51 : 5;
}

static bool check_device(const struct image *image, const avr_t *avr, const char *mcu)
{
    char name[32];
    device_name(image, name, sizeof(name));
    unsigned arch = header(image).e_flags & ARCH_MASK;
    if (name[0] && strcmp(name, mcu) != 0) {
        fprintf(stderr,
                "%s: built for %s, the board has an %s; --board is to name the board "
                "of the program\n",
                image->path, name, mcu);
        return false;
    }
    if (!name[0] && arch != architecture(avr)) {
        fprintf(stderr, "%s: built for a chip of avr-gcc's family avr%u, the board's %s is avr%u\n",
                image->path, arch, mcu, architecture(avr));
        return false;
    }
    return true;
}

static bool load_segment(struct image *image, avr_t *avr, const Elf32_Phdr *segment)
{
    uint8_t *bytes = image->file + segment->p_offset;
    uint64_t end = (uint64_t)segment->p_paddr + segment->p_filesz;
    if (segment->p_paddr >= EEPROM_BASE && end <= EEPROM_END) {
        avr_eeprom_desc_t eeprom = {.ee = bytes,
                                    .offset = (uint16_t)(segment->p_paddr - EEPROM_BASE),
                                    .size = segment->p_filesz};
        avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &eeprom); // simavr 1.6 returns -1 on success too
        return true;
    }
    if (segment->p_paddr >= DATA_BASE) {
        return true; // fuses, lock bits, signature
    }
    if (end > (uint64_t)avr->flashend + 1) {
        return refuse(image, "too big for the flash");
    }
    memcpy(avr->flash + segment->p_paddr, bytes, segment->p_filesz);
    if ((segment->p_flags & PF_X) && end > image->code_end) {
        image->code_end = (uint32_t)end;
    }
    return true;
}

bool image_load(struct image *image, avr_t *avr, const char *mcu)
{
    if (!check_device(image, avr, mcu)) {
        return false;
    }
    Elf32_Ehdr h = header(image);
    for (unsigned i = 0; i < h.e_phnum; i++) {
        Elf32_Phdr segment;
        memcpy(&segment, image->file + h.e_phoff + i * sizeof(segment), sizeof(segment));
        if (segment.p_type != PT_LOAD || !segment.p_filesz) {
            continue;
        }
        if (!within(image, segment.p_offset, segment.p_filesz)) {
            return refuse(image, "damaged ELF file");
        }
        if (!load_segment(image, avr, &segment)) {
            return false;
        }
    }
    return image->code_end > 0 || refuse(image, "no code in it");
}
