/* Lines of the console; see sentences.h. */
#include "sentences.h"

#include "texts.h" // PACKED_...

#define TEXT(name, text) static const CDS_FLASH char text_##name[] = PACKED_sentence_##name;
SENTENCES(TEXT)
#undef TEXT

const CDS_FLASH char *const CDS_FLASH sentences[SENTENCE_COUNT] = {
#define ROW(name, text) text_##name,
    SENTENCES(ROW)
#undef ROW
};
