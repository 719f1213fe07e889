/* The bench has one HAL for every family; see there. */
#include "wheelbench_hal.h"
