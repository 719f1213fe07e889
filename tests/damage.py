"""What a bad line does to a piece of bytes, by a seeded generator."""


def flip_one_bit(data, rng):
    bad = bytearray(data)
    bit = rng.randrange(8 * len(bad))
    bad[bit // 8] ^= 1 << bit % 8
    return bytes(bad)


def drop_a_byte(data, rng):
    at = rng.randrange(len(data))
    return data[:at] + data[at + 1 :]


def add_a_byte(data, rng):
    at = rng.randrange(len(data) + 1)
    return data[:at] + bytes((rng.randrange(256),)) + data[at:]
