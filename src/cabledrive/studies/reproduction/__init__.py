"""The dissertation item by item: printed, computed, deviation, verdict."""

from cabledrive.studies.reproduction.item import Entry, Item, Outcome
from cabledrive.studies.reproduction.run import Reproduction, reproduce

__all__ = ["Entry", "Item", "Outcome", "Reproduction", "reproduce"]
