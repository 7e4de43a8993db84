"""Transits of a canal, many abreast: as they truly are, as a filter knows them, as each predictor predicts them."""
