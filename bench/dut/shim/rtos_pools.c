/* Pools of blocks of one size in both versions of CMSIS-RTOS, and the mail queues of version 1, whose mail lies in one. */
#include "core.h"
#include "rtos.h"

#include "cmsis_os.h"

#include <string.h>

enum { ALIGNMENT = 8 };

struct wb_pool {
    uint32_t blocks, block_size, next;
    uint8_t *memory, *is_taken;
    SemaphoreHandle_t left; /* as many as are free: for whoever waits */
};

struct wb_mail {
    osPoolId pool;
    QueueHandle_t queue;
};

/* --- pools -------------------------------------------------------------------------------------------------------- */

static struct wb_pool *made(uint32_t blocks, uint32_t block_size) {
    struct wb_pool *pool = calloc(1, sizeof *pool);
    if (!pool)
        return NULL;
    pool->blocks = blocks;
    pool->block_size = (block_size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    pool->memory = calloc(blocks, pool->block_size);
    pool->is_taken = calloc(blocks, 1);
    pool->left = xSemaphoreCreateCounting(blocks, blocks);
    return pool;
}

static void *taken(struct wb_pool *pool, uint32_t ticks) {
    if (!xSemaphoreTake(pool->left, ticks))
        return NULL;
    while (pool->is_taken[pool->next])
        pool->next = (pool->next + 1) % pool->blocks;
    pool->is_taken[pool->next] = 1;
    return pool->memory + pool->next * pool->block_size;
}

static osStatus_t given_back(struct wb_pool *pool, const void *block) {
    size_t at = (size_t)((const uint8_t *)block - pool->memory);
    if (!block || (const uint8_t *)block < pool->memory || at % pool->block_size || at / pool->block_size >= pool->blocks)
        return osErrorParameter;
    if (!pool->is_taken[at / pool->block_size])
        return wb_is_version_1 ? osOK : osErrorResource; /* twice: version 1 does not see it */
    pool->is_taken[at / pool->block_size] = 0;
    xSemaphoreGive(pool->left);
    return osOK;
}

osPoolId osPoolCreate(const osPoolDef_t *definition) {
    return made(definition->pool_sz, definition->item_sz);
}

void *osPoolAlloc(osPoolId pool) {
    return taken(pool, 0);
}

void *osPoolCAlloc(osPoolId pool) {
    void *block = taken(pool, 0);
    return block ? memset(block, 0, pool->block_size) : NULL;
}

osStatus osPoolFree(osPoolId pool, void *block) {
    return pool ? given_back(pool, block) : osErrorParameter;
}

osMemoryPoolId_t osMemoryPoolNew(uint32_t blocks, uint32_t block_size, const osMemoryPoolAttr_t *attributes) {
    (void)attributes;
    return wb_in_interrupt || !blocks || !block_size ? NULL : made(blocks, block_size);
}

void *osMemoryPoolAlloc(osMemoryPoolId_t pool, uint32_t ticks) {
    return !pool || (wb_in_interrupt && ticks) ? NULL : taken(pool, ticks);
}

osStatus_t osMemoryPoolFree(osMemoryPoolId_t pool, void *block) {
    return osPoolFree(pool, block);
}

uint32_t osMemoryPoolGetCapacity(osMemoryPoolId_t pool) {
    return pool ? pool->blocks : 0;
}

uint32_t osMemoryPoolGetBlockSize(osMemoryPoolId_t pool) {
    return pool ? pool->block_size : 0;
}

uint32_t osMemoryPoolGetSpace(osMemoryPoolId_t pool) {
    return pool ? (uint32_t)uxSemaphoreGetCount(pool->left) : 0;
}

uint32_t osMemoryPoolGetCount(osMemoryPoolId_t pool) {
    return osMemoryPoolGetCapacity(pool) - osMemoryPoolGetSpace(pool);
}

osStatus_t osMemoryPoolDelete(osMemoryPoolId_t pool) {
    if (wb_in_interrupt || !pool)
        return pool ? osErrorISR : osErrorParameter;
    vSemaphoreDelete(pool->left);
    free(pool->memory);
    free(pool->is_taken);
    free(pool);
    return osOK;
}

/* --- mail --------------------------------------------------------------------------------------------------------- */

osMailQId osMailCreate(const osMailQDef_t *definition, osThreadId thread) {
    (void)thread;
    struct wb_mail *mail = calloc(1, sizeof *mail);
    if (!mail)
        return NULL;
    mail->pool = made(definition->queue_sz, definition->item_sz);
    mail->queue = xQueueCreate(definition->queue_sz, sizeof(void *));
    return mail;
}

void *osMailAlloc(osMailQId queue, uint32_t ticks) {
    (void)ticks; /* generated projects do not wait, whatever the book says: no room is no mail, at once */
    return queue ? osPoolAlloc(queue->pool) : NULL;
}

void *osMailCAlloc(osMailQId queue, uint32_t ticks) {
    (void)ticks;
    return queue ? osPoolCAlloc(queue->pool) : NULL;
}

osStatus osMailPut(osMailQId queue, void *mail) {
    if (!queue)
        return osErrorParameter;
    return xQueueSend(queue->queue, &mail, 0) ? osOK : osErrorOS;
}

osEvent osMailGet(osMailQId queue, uint32_t ticks) {
    uint32_t heeded = wb_in_interrupt ? 0 : ticks;
    osEvent event = {.status = heeded ? osEventTimeout : osOK, .def.mail_id = queue};
    if (!queue)
        event.status = osErrorParameter;
    else if (xQueueReceive(queue->queue, &event.value.p, heeded))
        event.status = osEventMail;
    return event;
}

osStatus osMailFree(osMailQId queue, void *mail) {
    return queue ? osPoolFree(queue->pool, mail) : osErrorParameter;
}
