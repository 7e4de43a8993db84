"""Waterways that bend and widen: places along a centreline, distances to both banks, depths, current."""

from narrows.waterway.banks import Bank as Bank
from narrows.waterway.centreline import Centreline as Centreline
from narrows.waterway.geojson import read_waterway as read_waterway
from narrows.waterway.geojson import write_waterway as write_waterway
from narrows.waterway.waterway import Waterway as Waterway
from narrows.waterway.waterway import straight_waterway as straight_waterway
