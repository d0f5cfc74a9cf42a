"""Rows of the job store, changed behind the daemon's back (server/jobs/store/job_store.cpp)."""
import contextlib
import sqlite3
import struct

from dccast.v1 import job_pb2

CRC_TABLE = []
for byte in range(256):
    for _ in range(8):
        byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
    CRC_TABLE.append(byte)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def framed(message):
    """A message as a row holds it: a byte of value 1 before it, length and checksum before both."""
    payload = b"\1" + message.SerializeToString()
    return struct.pack("<II", len(payload), crc32c(payload)) + payload


def change_rows(store, change, ahead=0):
    """Calls `change` with the job of each row, and writes the row again.
    @param ahead  what is added to the sequence of the last state that the row knows"""
    with contextlib.closing(sqlite3.connect(store, timeout=10)) as database, database:
        for key, blob in database.execute("SELECT id, job FROM job").fetchall():
            job = job_pb2.Job.FromString(blob[9:])
            change(job)
            database.execute("UPDATE job SET job = ?, title = ?, state = ?, sequence = sequence + ? "
                             "WHERE id = ?", (framed(job), job.title, job.state, ahead, key))
