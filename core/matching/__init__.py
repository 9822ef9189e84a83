"""The same shape found again by its umbilics: in another scan, among others, in itself."""
