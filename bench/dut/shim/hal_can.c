/* The HAL's calls on the motors' bus, of a bxCAN and of an FDCAN. A controller that nobody starts is silent. */
#include "core.h"
#include "hal.h"

#include <string.h>

enum { MAILBOXES = 3 };

CAN_TypeDef wb_can_instance[4];
FDCAN_GlobalTypeDef wb_fdcan_instance[4];

/* The firmware's own, where it has them. */
void OPTIONAL HAL_CAN_RxFifo0MsgPendingCallback(CAN_HandleTypeDef *can);
void OPTIONAL HAL_CAN_RxFifo1MsgPendingCallback(CAN_HandleTypeDef *can);
void OPTIONAL HAL_CAN_TxMailbox0CompleteCallback(CAN_HandleTypeDef *can);
void OPTIONAL HAL_CAN_TxMailbox1CompleteCallback(CAN_HandleTypeDef *can);
void OPTIONAL HAL_CAN_TxMailbox2CompleteCallback(CAN_HandleTypeDef *can);
void OPTIONAL HAL_FDCAN_RxFifo0Callback(FDCAN_HandleTypeDef *can, uint32_t which);
void OPTIONAL HAL_FDCAN_RxFifo1Callback(FDCAN_HandleTypeDef *can, uint32_t which);
void OPTIONAL HAL_FDCAN_MspInit(FDCAN_HandleTypeDef *can);
void OPTIONAL HAL_CAN_MspInit(CAN_HandleTypeDef *can);

/* --- what both kinds ask ------------------------------------------------------------------------------------------ */

static uint32_t places_to_send(void) {
    if (wb_can_room() == 0)
        wb_poll();
    return (uint32_t)(wb_can_room() < MAILBOXES ? wb_can_room() : MAILBOXES);
}

static uint32_t frames_waiting(int in_this_fifo) {
    if (!in_this_fifo || wb_can_waiting() == 0)
        wb_poll();
    return in_this_fifo ? (uint32_t)wb_can_waiting() : 0;
}

/* --- bxCAN -------------------------------------------------------------------------------------------------------- */

static int is_the_bus(const CAN_HandleTypeDef *can) {
    return can && can == wb_hal_can && can->State == HAL_CAN_STATE_LISTENING;
}

HAL_StatusTypeDef OPTIONAL HAL_CAN_Init(CAN_HandleTypeDef *can) {
    if (!can)
        return HAL_ERROR;
    if (HAL_CAN_MspInit)
        HAL_CAN_MspInit(can);
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_ConfigFilter(CAN_HandleTypeDef *can, const CAN_FilterTypeDef *filter) {
    UNUSED(can); /* every frame passes */
    UNUSED(filter);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_Start(CAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_LISTENING;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_Stop(CAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_ActivateNotification(CAN_HandleTypeDef *can, uint32_t which) {
    can->wb_notifications |= which;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_DeactivateNotification(CAN_HandleTypeDef *can, uint32_t which) {
    can->wb_notifications &= ~which;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_AddTxMessage(
    CAN_HandleTypeDef *can, const CAN_TxHeaderTypeDef *header, const uint8_t data[], uint32_t *mailbox) {
    if (!can || (can->State != HAL_CAN_STATE_LISTENING && can->State != HAL_CAN_STATE_READY))
        return HAL_ERROR;
    if (header->DLC > 8)
        return HAL_ERROR;
    if (mailbox)
        *mailbox = CAN_TX_MAILBOX0 << can->wb_sent % MAILBOXES;
    if (!is_the_bus(can))
        return HAL_OK; /* another bus, with nobody on it; or not started: it waits in its mailbox for ever */
    if (header->IDE != CAN_ID_STD || header->RTR != CAN_RTR_DATA) {
        wb_note_once("an extended or remote CAN frame was sent; the motors' bus carries none, and it is left out");
        return HAL_OK;
    }
    if (!wb_can_write((uint16_t)header->StdId, data, (uint8_t)header->DLC))
        return HAL_ERROR;
    can->wb_sent++;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_GetRxMessage(CAN_HandleTypeDef *can, uint32_t fifo, CAN_RxHeaderTypeDef *header, uint8_t data[]) {
    uint16_t id = 0;
    uint8_t bytes[8], length = 0;
    if (!is_the_bus(can) || fifo != wb_hal_fifo || !wb_can_read(&id, bytes, &length)) {
        wb_poll();
        return HAL_ERROR;
    }
    memset(header, 0, sizeof *header);
    header->StdId = id;
    header->IDE = CAN_ID_STD;
    header->RTR = CAN_RTR_DATA;
    header->DLC = length;
    header->Timestamp = wb_tick & 0xFFFF;
    memcpy(data, bytes, length);
    return HAL_OK;
}

uint32_t HAL_CAN_GetTxMailboxesFreeLevel(const CAN_HandleTypeDef *can) {
    UNUSED(can);
    return places_to_send();
}

uint32_t HAL_CAN_GetRxFifoFillLevel(const CAN_HandleTypeDef *can, uint32_t fifo) {
    return frames_waiting(is_the_bus(can) && fifo == wb_hal_fifo);
}

uint32_t HAL_CAN_IsTxMessagePending(const CAN_HandleTypeDef *can, uint32_t mailboxes) {
    UNUSED(can);
    UNUSED(mailboxes);
    return 0;
}

uint32_t HAL_CAN_GetState(const CAN_HandleTypeDef *can) {
    return can->State;
}

uint32_t HAL_CAN_GetError(const CAN_HandleTypeDef *can) {
    return can->ErrorCode;
}

HAL_StatusTypeDef HAL_CAN_RegisterCallback(
    CAN_HandleTypeDef *can, HAL_CAN_CallbackIDTypeDef which, void (*call)(CAN_HandleTypeDef *)) {
    if (which == HAL_CAN_RX_FIFO0_MSG_PENDING_CB_ID)
        can->RxFifo0MsgPendingCallback = call;
    else if (which == HAL_CAN_RX_FIFO1_MSG_PENDING_CB_ID)
        can->RxFifo1MsgPendingCallback = call;
    else if (which == HAL_CAN_TX_MAILBOX0_COMPLETE_CB_ID)
        can->TxMailbox0CompleteCallback = call;
    else if (which == HAL_CAN_TX_MAILBOX1_COMPLETE_CB_ID)
        can->TxMailbox1CompleteCallback = call;
    else if (which == HAL_CAN_TX_MAILBOX2_COMPLETE_CB_ID)
        can->TxMailbox2CompleteCallback = call;
    return HAL_OK;
}

void OPTIONAL HAL_CAN_IRQHandler(CAN_HandleTypeDef *can) {
    UNUSED(can);
}

/* --- FDCAN, for classic frames ------------------------------------------------------------------------------------ */

static int is_the_fd_bus(const FDCAN_HandleTypeDef *can) {
    return can && can == wb_hal_fdcan && can->State == HAL_CAN_STATE_LISTENING;
}

HAL_StatusTypeDef OPTIONAL HAL_FDCAN_Init(FDCAN_HandleTypeDef *can) {
    if (!can)
        return HAL_ERROR;
    if (HAL_FDCAN_MspInit)
        HAL_FDCAN_MspInit(can);
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_ConfigFilter(FDCAN_HandleTypeDef *can, const FDCAN_FilterTypeDef *filter) {
    UNUSED(can); /* every frame passes */
    UNUSED(filter);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_ConfigGlobalFilter(
    FDCAN_HandleTypeDef *can, uint32_t standard, uint32_t extended, uint32_t remote_standard, uint32_t remote_extended) {
    UNUSED(can);
    UNUSED(standard + extended + remote_standard + remote_extended);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_Start(FDCAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_LISTENING;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_Stop(FDCAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_ActivateNotification(FDCAN_HandleTypeDef *can, uint32_t which, uint32_t buffers) {
    UNUSED(buffers);
    can->wb_notifications |= which;
    return HAL_OK;
}

/* A length code: 0 to 8, or as older versions of the interface have it, shifted by 16. */
static uint32_t length_of(uint32_t code) {
    return code > 0xFFFF ? code >> 16 : code;
}

HAL_StatusTypeDef HAL_FDCAN_AddMessageToTxFifoQ(
    FDCAN_HandleTypeDef *can, const FDCAN_TxHeaderTypeDef *header, const uint8_t *data) {
    if (!can || can->State != HAL_CAN_STATE_LISTENING)
        return HAL_ERROR;
    if (!is_the_fd_bus(can))
        return HAL_OK; /* another bus, with nobody on it */
    if (header->IdType != FDCAN_STANDARD_ID || header->TxFrameType != FDCAN_DATA_FRAME || length_of(header->DataLength) > 8) {
        wb_note_once("an extended, remote or long CAN frame was sent; the motors' bus carries none, and it is left out");
        return HAL_OK;
    }
    if (header->FDFormat == FDCAN_FD_CAN) {
        wb_note_once("a frame in FD format was sent (FDFormat); the motors are classic CAN and answer it with an error frame: "
                     "it is left out");
        return HAL_OK;
    }
    return wb_can_write((uint16_t)header->Identifier, data, (uint8_t)length_of(header->DataLength)) ? HAL_OK : HAL_ERROR;
}

static uint32_t fd_fifo(void) {
    return wb_hal_fifo == CAN_RX_FIFO0 ? FDCAN_RX_FIFO0 : FDCAN_RX_FIFO1;
}

HAL_StatusTypeDef HAL_FDCAN_GetRxMessage(
    FDCAN_HandleTypeDef *can, uint32_t fifo, FDCAN_RxHeaderTypeDef *header, uint8_t *data) {
    uint16_t id = 0;
    uint8_t bytes[8], length = 0;
    if (!is_the_fd_bus(can) || fifo != fd_fifo() || !wb_can_read(&id, bytes, &length)) {
        wb_poll();
        return HAL_ERROR;
    }
    memset(header, 0, sizeof *header);
    header->Identifier = id;
    header->DataLength = length;
    header->RxTimestamp = wb_tick & 0xFFFF;
    memcpy(data, bytes, length);
    return HAL_OK;
}

uint32_t HAL_FDCAN_GetTxFifoFreeLevel(const FDCAN_HandleTypeDef *can) {
    UNUSED(can);
    return places_to_send();
}

uint32_t HAL_FDCAN_GetRxFifoFillLevel(const FDCAN_HandleTypeDef *can, uint32_t fifo) {
    return frames_waiting(is_the_fd_bus(can) && fifo == fd_fifo());
}

HAL_StatusTypeDef HAL_FDCAN_RegisterRxFifo0Callback(
    FDCAN_HandleTypeDef *can, void (*call)(FDCAN_HandleTypeDef *, uint32_t)) {
    can->RxFifo0Callback = call;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_RegisterRxFifo1Callback(
    FDCAN_HandleTypeDef *can, void (*call)(FDCAN_HandleTypeDef *, uint32_t)) {
    can->RxFifo1Callback = call;
    return HAL_OK;
}

void OPTIONAL HAL_FDCAN_IRQHandler(FDCAN_HandleTypeDef *can) {
    UNUSED(can);
}

/* --- frames that arrive, on either -------------------------------------------------------------------------------- */

static void fdcan_interrupts(const struct wb_input *input) {
    FDCAN_HandleTypeDef *can = wb_hal_fdcan;
    int is_first = wb_hal_fifo == CAN_RX_FIFO0;
    uint32_t wanted = is_first ? FDCAN_IT_RX_FIFO0_NEW_MESSAGE : FDCAN_IT_RX_FIFO1_NEW_MESSAGE;
    for (int i = 0; i < input->frame_count && can->State == HAL_CAN_STATE_LISTENING; i++) {
        wb_keep_frame(&input->frames[i]);
        if (!(can->wb_notifications & wanted))
            continue;
        if (is_first)
            WB_CALL(can->RxFifo0Callback, HAL_FDCAN_RxFifo0Callback, can, wanted);
        else
            WB_CALL(can->RxFifo1Callback, HAL_FDCAN_RxFifo1Callback, can, wanted);
    }
}

/* What was sent in the millisecond that is over has left its mailbox. */
static void sent_interrupts(CAN_HandleTypeDef *can) {
    uint32_t sent = can->wb_sent;
    can->wb_sent = 0; /* a callback may send again */
    for (uint32_t i = 0; i < sent && can->wb_notifications & CAN_IT_TX_MAILBOX_EMPTY; i++) {
        if (i % MAILBOXES == 0)
            WB_CALL(can->TxMailbox0CompleteCallback, HAL_CAN_TxMailbox0CompleteCallback, can);
        else if (i % MAILBOXES == 1)
            WB_CALL(can->TxMailbox1CompleteCallback, HAL_CAN_TxMailbox1CompleteCallback, can);
        else
            WB_CALL(can->TxMailbox2CompleteCallback, HAL_CAN_TxMailbox2CompleteCallback, can);
    }
}

void wb_can_interrupts(const struct wb_input *input) {
    CAN_HandleTypeDef *can = wb_hal_can;
    if (wb_hal_fdcan) {
        fdcan_interrupts(input);
        return;
    }
    if (can)
        sent_interrupts(can);
    uint32_t wanted = wb_hal_fifo == CAN_RX_FIFO0 ? CAN_IT_RX_FIFO0_MSG_PENDING : CAN_IT_RX_FIFO1_MSG_PENDING;
    for (int i = 0; i < input->frame_count; i++) {
        if (can && can->State != HAL_CAN_STATE_LISTENING)
            continue; /* a controller that has not been started hears nothing */
        wb_keep_frame(&input->frames[i]);
        if (!can || !(can->wb_notifications & wanted))
            continue;
        if (wb_hal_fifo == CAN_RX_FIFO0)
            WB_CALL(can->RxFifo0MsgPendingCallback, HAL_CAN_RxFifo0MsgPendingCallback, can);
        else
            WB_CALL(can->RxFifo1MsgPendingCallback, HAL_CAN_RxFifo1MsgPendingCallback, can);
    }
}
