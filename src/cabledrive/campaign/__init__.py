"""Campaigns: thousands to millions of variants of a drive, computed in chunks, in one labelled store."""

from cabledrive.campaign.computation import Computation, Found, Output, Row
from cabledrive.campaign.design import Design
from cabledrive.campaign.run import SweepResult, run_sweep
from cabledrive.campaign.spec import CampaignSpec

__all__ = ["CampaignSpec", "Computation", "Design", "Found", "Output", "Row", "SweepResult", "run_sweep"]
