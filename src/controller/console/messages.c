/* Texts that several files share; see messages.h. */
#include "console/messages.h"

const CDS_FLASH char message_nothing[] = "";
