"""narrows: from captive model tests to a closed-form bank-effect model that says how far it can be trusted."""

from narrows.captive import CaptiveTests as CaptiveTests
from narrows.captive import read_captive as read_captive
from narrows.captive import stream_captive as stream_captive
from narrows.errors import InputError as InputError
from narrows.identify import Fit as Fit
from narrows.identify import identify as identify
from narrows.model import Model as Model
from narrows.model_file import load_model as load_model
from narrows.model_file import published as published
from narrows.model_file import save_model as save_model
from narrows.motion import Motion as Motion
from narrows.particulars import Canal as Canal
from narrows.particulars import Setting as Setting
from narrows.particulars import Ship as Ship
from narrows.particulars import Water as Water
from narrows.particulars import read_ship as read_ship
from narrows.terms import PAPER as PAPER
from narrows.terms import TAPERED as TAPERED
from narrows.terms import Term as Term
from narrows.terms import TermTable as TermTable
