/* See cmsis_os.h. */
#include "cmsis_os.h"
