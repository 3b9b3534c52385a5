/* The library's header, so that one folder (-Icompat) is enough. BEAMTICK_CARDS: the family for several cards. */
#ifdef BEAMTICK_CARDS
#include "../include/gts_cards.h"
#else
#include "../include/gts.h"
#endif
