/* SPDX-License-Identifier: MIT */
/* The byte ring: order, fullness, and indices that wrap. */
#include "cds55xx/ring.h"

#include "unity.h"

static struct {
    uint8_t before[4];
    struct cds_ring ring;
    uint8_t after[4];
} guarded;

static struct cds_ring *const ring = &guarded.ring;

/* An empty ring whose indices both stand at `offset`, as after that many bytes have passed. */
static void empty_at(uint8_t offset)
{
    ring->head = offset;
    ring->tail = offset;
}

static void fill(uint8_t count, uint8_t first)
{
    for (uint8_t i = 0; i < count; i++)
        TEST_ASSERT_TRUE(cds_ring_put(ring, (uint8_t)(first + i)));
}

/* The byte `offset` after the oldest. */
static uint8_t peek(uint8_t offset)
{
    return cds_ring_at(ring, cds_ring_after(cds_ring_begin(ring), offset));
}

/* Takes out the `count` oldest bytes. */
static void drop(uint8_t count)
{
    cds_ring_release(ring, cds_ring_after(cds_ring_begin(ring), count));
}

void setUp(void)
{
    for (uint8_t i = 0; i < 4; i++)
        guarded.before[i] = guarded.after[i] = 0xA5;
    for (uint8_t i = 0; i < CDS_RING_SIZE; i++)
        ring->bytes[i] = 0;
    empty_at(0);
}

void tearDown(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_HEX8(0xA5, guarded.before[i]);
        TEST_ASSERT_EQUAL_HEX8(0xA5, guarded.after[i]);
    }
}

void test_new_ring_is_empty(void)
{
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(ring));
}

void test_byte_put_is_the_byte_seen(void)
{
    TEST_ASSERT_TRUE(cds_ring_put(ring, 0xC3));
    TEST_ASSERT_EQUAL_UINT8(1, cds_ring_count(ring));
    TEST_ASSERT_EQUAL_HEX8(0xC3, peek(0));
}

void test_looking_takes_nothing_out(void)
{
    fill(3, 10);
    TEST_ASSERT_EQUAL_UINT8(12, peek(2));
    TEST_ASSERT_EQUAL_UINT8(10, peek(0));
    TEST_ASSERT_EQUAL_UINT8(3, cds_ring_count(ring));
}

void test_drop_takes_the_oldest(void)
{
    fill(5, 1);
    drop(2);
    TEST_ASSERT_EQUAL_UINT8(3, cds_ring_count(ring));
    TEST_ASSERT_EQUAL_UINT8(3, peek(0));
    TEST_ASSERT_EQUAL_UINT8(5, peek(2));
}

void test_drop_of_none_changes_nothing(void)
{
    fill(2, 1);
    drop(0);
    TEST_ASSERT_EQUAL_UINT8(2, cds_ring_count(ring));
    TEST_ASSERT_EQUAL_UINT8(1, peek(0));
}

void test_every_place_of_the_ring_is_used(void)
{
    fill(CDS_RING_SIZE, 0);
    TEST_ASSERT_EQUAL_UINT8(CDS_RING_SIZE, cds_ring_count(ring));
}

void test_full_ring_refuses_and_keeps_what_it_has(void)
{
    fill(CDS_RING_SIZE, 0);
    TEST_ASSERT_FALSE(cds_ring_put(ring, 0xEE));
    TEST_ASSERT_EQUAL_UINT8(CDS_RING_SIZE, cds_ring_count(ring));
    for (uint8_t i = 0; i < CDS_RING_SIZE; i++)
        TEST_ASSERT_EQUAL_UINT8(i, peek(i));
}

void test_full_ring_takes_again_after_a_drop(void)
{
    fill(CDS_RING_SIZE, 0);
    drop(1);
    TEST_ASSERT_TRUE(cds_ring_put(ring, 0xEE));
    TEST_ASSERT_FALSE(cds_ring_put(ring, 0xEF));
    TEST_ASSERT_EQUAL_HEX8(0xEE, peek(CDS_RING_SIZE - 1));
}

/* The indices wrap at 256, the places at CDS_RING_SIZE: every pair of them must do. */
void test_order_holds_from_every_offset(void)
{
    for (uint16_t offset = 0; offset < 256; offset++) {
        empty_at((uint8_t)offset);
        fill(CDS_RING_SIZE, (uint8_t)offset);
        TEST_ASSERT_FALSE(cds_ring_put(ring, 0));
        for (uint8_t i = 0; i < CDS_RING_SIZE; i++)
            TEST_ASSERT_EQUAL_UINT8((uint8_t)(offset + i), peek(i));
        drop(CDS_RING_SIZE);
        TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(ring));
    }
}

void test_positions_from_every_offset(void)
{
    for (uint16_t offset = 0; offset < 256; offset++) {
        empty_at((uint8_t)offset);
        TEST_ASSERT_EQUAL_UINT8(cds_ring_begin(ring), cds_ring_end(ring));
        fill(5, 1);
        TEST_ASSERT_EQUAL_UINT8(5, cds_ring_distance(cds_ring_begin(ring), cds_ring_end(ring)));
        TEST_ASSERT_EQUAL_UINT8(cds_ring_end(ring), cds_ring_after(cds_ring_begin(ring), 5));
        drop(2);
        TEST_ASSERT_EQUAL_UINT8(3, cds_ring_distance(cds_ring_begin(ring), cds_ring_end(ring)));
        TEST_ASSERT_EQUAL_UINT8(3, cds_ring_at(ring, cds_ring_begin(ring)));
    }
}

void test_thousand_bytes_pass_in_order(void)
{
    uint8_t put = 0, taken = 0;

    for (uint16_t i = 0; i < 1000; i++) { // three in, two or four out: it fills and empties
        uint8_t out = i & 1 ? 4 : 2;

        for (uint8_t j = 0; j < 3; j++)
            TEST_ASSERT_TRUE(cds_ring_put(ring, put++));
        for (uint8_t j = 0; j < out; j++) {
            TEST_ASSERT_EQUAL_UINT8(taken, peek(0));
            drop(1);
            taken++;
        }
    }
    TEST_ASSERT_EQUAL_UINT8(0, cds_ring_count(ring));
}
