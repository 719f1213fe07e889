/* The chip's own USB port, which generators set up: nobody is plugged in, and what is sent there is printed. */
#ifndef WHEELBENCH_USB_DEVICE_H
#define WHEELBENCH_USB_DEVICE_H

#ifdef __cplusplus
extern "C" {
#endif

void MX_USB_DEVICE_Init(void);

#ifdef __cplusplus
}
#endif
#endif
