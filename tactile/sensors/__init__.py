"""Tactile sensors: their protocol, drivers, recordings, zeroing and faults.

A driver implements :class:`TactileSensor`. :class:`ContactSensor` converts its images to features,
removes the drift of the readings at rest, and names faults. :class:`TactileRecorder` writes MCAP
files, and :class:`RecordedSensor` plays them.
"""

from ..phase_step import SensorFault
from .contact_sensor import ContactReading, ContactSensor
from .protocol import SensorInfo, TactileFrame, TactileSensor
from .recording import RecordedSensor, TactileRecorder, record
from .rest_tracker import RestTracker
from .sensor_monitor import SensorMonitor
from .serial_sensor import SerialSensor, serial_4x6_shear, serial_16x16

__all__ = [
    "ContactReading",
    "ContactSensor",
    "RecordedSensor",
    "RestTracker",
    "SensorFault",
    "SensorInfo",
    "SensorMonitor",
    "SerialSensor",
    "TactileFrame",
    "TactileRecorder",
    "TactileSensor",
    "record",
    "serial_4x6_shear",
    "serial_16x16",
]
