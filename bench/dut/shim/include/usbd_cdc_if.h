/* A serial line over USB, towards the host; see usb_device.h. */
#ifndef WHEELBENCH_USBD_CDC_IF_H
#define WHEELBENCH_USBD_CDC_IF_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { USBD_OK = 0, USBD_BUSY = 1, USBD_FAIL = 2 };
uint8_t CDC_Transmit_FS(uint8_t *data, uint16_t size);
uint8_t CDC_Transmit_HS(uint8_t *data, uint16_t size);

#ifdef __cplusplus
}
#endif
#endif
